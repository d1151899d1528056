use sagnac::{backend::{Job,cpu::*,gpu::*,gpu::source::Variant}, block::*, kernel::gap_fill::*};
fn main(){
  let shape=Shape{before:4,after:2,residual_before:2,extrapolation_before:4,fillers:3};
  let w=Parameters{key:&[1,2],phase:&[0],phase_spread:&[!0],sigma:&[139810],gap_sin:&[1<<22],gap_cos:&[1<<22],before_sin:&[1<<20;4],before_cos:&[1<<20;4],after_sin:&[1<<20;2],after_cos:&[1<<20;2],
   residual_weight:&[3,3,3,3,3,3,3,3,5,-2i32 as u32,5,-2i32 as u32],residual_scale:&[4,4,2],extrapolation_weight:&[3,3,3,3,39,18,-3i32 as u32,-24i32 as u32,253,-139i32 as u32,-181i32 as u32,127],extrapolation_scale:&[4,10,20],bin_base:&[2000;6]}.words();
  let l=Launch{shape,words:w};
  let n=22u32; let jobs:Vec<_>=cover(0..(1<<n),18).into_iter().map(|block|Job{launch:&l,block}).collect();
  let none=|_:u64|{};
  for hist in [false,true]{ let mut want=None; for width in Width::available(){
    let cpu=Cpu::new(width,0).unwrap(); let mut best=1e9f64; let mut r=vec![];
    for _ in 0..5 { let t=std::time::Instant::now(); r=cpu.tally(&jobs,hist,&none); best=best.min(t.elapsed().as_secs_f64()); }
    println!("{} hist {hist}: {:.1} M/s ", cpu.name(), (1u64<<n) as f64/best/1e6);
    if let Some(w)=&want { assert!(w==&r);} else {want=Some(r);}
  }
  for a in Adapter::all(){ println!("{} {}",a.name(),a.description());
   for v in [a.variant(),Variant{int64:false,..a.variant()},Variant{checked:true,..a.variant()},Variant{workgroup:32,..a.variant()},Variant{workgroup:128,..a.variant()}] {
    let mut g=Gpu::open(&a,v).unwrap(); let mut best=1e9f64; let mut r=vec![];
    let t0=std::time::Instant::now();
    for i in 0..5 { let t=std::time::Instant::now(); r=g.tally(&jobs,hist,&none).unwrap(); best=best.min(t.elapsed().as_secs_f64()); if i==0 {println!("first {:.2}s",t0.elapsed().as_secs_f64());} }
    println!("{v:?} hist {hist}: {:.1} M/s same {}", (1u64<<n) as f64/best/1e6, Some(&r)==want.as_ref());
   }}
  }
}

use sagnac::{backend::{Job,gpu::*}, block::*, kernel::gap_fill::*};
fn main(){
  let shape=Shape{before:4,after:2,residual_before:2,extrapolation_before:4,fillers:3};
  let w=Parameters{key:&[1,2],phase:&[0],phase_spread:&[!0],sigma:&[139810],gap_sin:&[1<<22],gap_cos:&[1<<22],before_sin:&[1<<20;4],before_cos:&[1<<20;4],after_sin:&[1<<20;2],after_cos:&[1<<20;2],
   residual_weight:&[3,3,3,3,3,3,3,3,5,-2i32 as u32,5,-2i32 as u32],residual_scale:&[4,4,2],extrapolation_weight:&[3,3,3,3,39,18,-3i32 as u32,-24i32 as u32,253,-139i32 as u32,-181i32 as u32,127],extrapolation_scale:&[4,10,20],bin_base:&[2000;6]}.words();
  let l=Launch{shape,words:w};
  let n=23u32; let jobs:Vec<_>=cover(0..(1<<n),20).into_iter().map(|block|Job{launch:&l,block}).collect();
  let hist=std::env::args().nth(1).is_some();
  for a in Adapter::all(){ 
    let mut g=Gpu::open(&a,a.variant()).unwrap(); let mut best=1e9f64;
    for _ in 0..4 { let t=std::time::Instant::now(); g.tally(&jobs,hist,&|_|{}).unwrap(); best=best.min(t.elapsed().as_secs_f64()); }
    println!("{:.1} M/s", (1u64<<n) as f64/best/1e6);
   }
}

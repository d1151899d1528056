use sagnac::{backend::cpu::Width, kernel::gap_fill::*};
fn main(){
  let shape=Shape{before:4,after:2,residual_before:2,extrapolation_before:4,fillers:3};
  let w=Parameters{key:&[1,2],phase:&[0],phase_spread:&[!0],sigma:&[139810],gap_sin:&[1<<22],gap_cos:&[1<<22],before_sin:&[1<<20;4],before_cos:&[1<<20;4],after_sin:&[1<<20;2],after_cos:&[1<<20;2],
   residual_weight:&[3,3,3,3,3,3,3,3,5,-2i32 as u32,5,-2i32 as u32],residual_scale:&[4,4,2],extrapolation_weight:&[3,3,3,3,39,18,-3i32 as u32,-24i32 as u32,253,-139i32 as u32,-181i32 as u32,127],extrapolation_scale:&[4,10,20],bin_base:&[2000;6]}.words();
  let l=Launch{shape,words:w};
  for hist in [false,true]{ for width in Width::available(){
    let mut best=1e9f64; let mut r=vec![];
    let n:u64 = if width==Width::Portable {1<<22} else {1<<24};
    for _ in 0..3 { let t=std::time::Instant::now(); 
    let hs: Vec<_> = (0..2u64).map(|i|{let l=l.clone(); std::thread::spawn(move||{ let mut m: Vec<_> = vec![]; for c in 0..(n/65536) { let t=tally(width,&l,(i*n)+c*65536,65536,hist); if m.is_empty(){m=t}else{for (a,b) in m.iter_mut().zip(&t){a.merge(b)}} } m})}).collect();
    r=hs.into_iter().map(|h|h.join().unwrap()).collect(); best=best.min(t.elapsed().as_secs_f64()); }
    println!("{} hist {hist}: {:.1} M/s  sum {:x}", width.name(), 2.0*n as f64/best/1e6, r[0][5].square);
  }}
}

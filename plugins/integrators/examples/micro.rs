use bhs_integrators::orbit::*; use bhs_integrators::taylor::*; use std::hint::black_box; use std::time::Instant; use glam::DVec3;
fn time(name:&str, mut f: impl FnMut(usize)->f64){ let n=300_000; let mut best=f64::MAX; for _ in 0..7 { let t=Instant::now(); let mut s=0.0; for i in 0..n { s+=f(i);} black_box(s); best=best.min(t.elapsed().as_secs_f64()/n as f64*1e9);} println!("{name}: {best:.1} ns"); }
fn main(){
 let m=4096; let mut seed=1u64; let mut r=||{seed=seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407); (seed>>11) as f64/(1u64<<53) as f64};
 let rays:Vec<(DVec3,DVec3)>=(0..m).map(|_|{ let o=DVec3::new(r()*2.0-1.0,r()*1.5-0.8,r()*2.0-0.4); let d=DVec3::new(r()-0.5,r()-0.5,r()-0.5).normalize(); (o,d)}).collect();
 let rs=0.07;
 let states:Vec<_>=rays.iter().map(|(o,d)|OrbitPlane::of_ray(DVec3::ZERO,*o,*d)).collect();
 time("of_ray",|i|{let (o,d)=rays[i&4095]; OrbitPlane::of_ray(DVec3::ZERO,o,d).1.du});
 time("new",|i|{let s=TaylorOrbit::new(rs,states[i&4095].1,1e-5); black_box(s); 0.0});
 time("new+advance",|i|{let mut s=TaylorOrbit::new(rs,states[i&4095].1,1e-5); let (st,_)=s.advance(); black_box(&st); st.end().u});
 time("new+2 advance",|i|{let mut s=TaylorOrbit::new(rs,states[i&4095].1,1e-5); let (st,f)=s.advance(); if f==Fate::Underway {let (st,_)=s.advance(); return black_box(st).end().u}; black_box(&st); st.end().u});
 let steps:Vec<_>=states.iter().map(|s|TaylorOrbit::new(rs,s.1,1e-5).advance().0).collect();
 let esc=states.iter().map(|s|TaylorOrbit::new(rs,s.1,1e-5).advance()).filter(|x|x.1!=Fate::Underway).count(); println!("ended in first step {esc} of {m}; mean step {}", steps.iter().map(|s|s.end().phi).sum::<f64>()/m as f64);
 time("u_at",|i|{let s=&steps[i&4095]; s.u_at(0.3+1e-9*i as f64)});
 time("at",|i|{let s=&steps[i&4095]; s.at(0.3+1e-9*i as f64).du});
 time("radial",|i|{let s=&states[i&4095].0; s.radial(0.3+1e-6*i as f64).x});
 time("hypot",|i| (i as f64).hypot(3.0));
 time("powf",|i| (1e-9*(1+i) as f64).powf(1.0/14.0));

 time("coeff loop",|i|{let s=states[i&4095].1; let c=coef(rs,s.u,s.du); c[15]+c[14]});
 time("coeff unrolled",|i|{let s=states[i&4095].1; let c=coef2(rs,s.u,s.du); c[15]+c[14]});
 time("crossing",|i|{let s=&steps[i&4095]; if s.end().u<1e-9 {1.0} else { s.crossing(s.start(), s.end(), 0.5*(s.start().u+s.end().u)).phi}});
}
const TERMS:usize=16;
fn coef(rs: f64, u: f64, du: f64) -> [f64; TERMS] {
    let mut c = [0.0; TERMS];
    (c[0], c[1]) = (u, du);
    for n in 0..TERMS - 2 {
        let pairs: f64 = (0..n.div_ceil(2)).map(|i| c[i] * c[n - i]).sum();
        let middle = if n % 2 == 0 { c[n / 2] * c[n / 2] } else { 0.0 };
        c[n + 2] = (1.5 * rs * (2.0 * pairs + middle) - c[n]) * (1.0 / ((n + 1) * (n + 2)) as f64);
    }
    c
}
fn coef2(rs: f64, u: f64, du: f64) -> [f64; TERMS] {
    let mut c = [0.0; TERMS];
    (c[0], c[1]) = (u, du);
    let bend = 1.5 * rs;
    macro_rules! next { ($($n:literal)*) => { $( c[$n + 2] = next::<$n>(&c, bend); )* }; }
    next!(0 1 2 3 4 5 6 7 8 9 10 11 12 13);
    c
}
#[inline(always)]
fn next<const N: usize>(c: &[f64; TERMS], bend: f64) -> f64 {
    let mut pairs = 0.0;
    for i in 0..N.div_ceil(2) { pairs += c[i] * c[N - i]; }
    let middle = if N % 2 == 0 { c[N / 2] * c[N / 2] } else { 0.0 };
    (bend * (2.0 * pairs + middle) - c[N]) * (1.0 / ((N + 1) * (N + 2)) as f64)
}

use caustica::format::mesh;
use std::time::Instant;
fn main() {
    for name in std::env::args().skip(1).filter(|a| !a.starts_with("--")) {
        for _ in 0..3 {
            let t = Instant::now();
            let n = mesh::load(name.as_ref(), &()).unwrap().mesh.triangles.len();
            let s = t.elapsed().as_secs_f64();
            println!("{name} {n} {s:.3} s {:.2} M/s", n as f64 / s / 1e6);
        }
    }
}

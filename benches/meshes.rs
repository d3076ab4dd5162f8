//! Benchmarks of meshes of 2.5 million triangles: reading, writing, reports, normals: `cargo bench
//! --bench meshes`.

use caustica::format::mesh::{self, MeshFormat, MeshRepairOptions, TriangleMesh};
use divan::Bencher;
use divan::counter::ItemsCount;
use glam::DVec3;
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::LazyLock;

fn main() {
    divan::main();
}

const N: u32 = 1250;
const M: u32 = 1000;
const TRIANGLES: u32 = 2 * N * M;

/// Returns a torus of quads, each cut in two triangles.
fn torus(normals: bool) -> TriangleMesh {
    let circle = |i: u32, n: u32| libm::sincos(TAU * f64::from(i) / f64::from(n));
    let mut mesh = TriangleMesh::default();
    let mut directions = Vec::new();
    for i in 0..N {
        for j in 0..M {
            let ((s, c), (t, d)) = (circle(i, N), circle(j, M));
            mesh.positions.push(DVec3::new((2.0 + d) * c, (2.0 + d) * s, t));
            directions.push(DVec3::new(d * c, d * s, t).normalize());
        }
    }
    let k = |i: u32, j: u32| i % N * M + j % M;
    for i in 0..N {
        for j in 0..M {
            let [a, b, c, d] = [k(i, j), k(i + 1, j), k(i + 1, j + 1), k(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh.normals = normals.then_some(directions);
    mesh
}

const FILES: [&str; 4] = ["flat.obj", "smooth.obj", "binary.ply", "text.ply"];

static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder for meshes");
    FILES.iter().for_each(|name| write(name, &folder.path().join(name)));
    folder
});

fn write(name: &str, path: &Path) {
    let format = MeshFormat::from_path(path, name.starts_with("text")).expect("a form of meshes");
    torus(name.starts_with("smooth")).write(path, format, &[]).expect("room for a mesh");
}

#[divan::bench(args = FILES, sample_count = 5, sample_size = 1)]
fn load(bencher: Bencher, name: &str) {
    let path = FOLDER.path().join(name);
    bencher.counter(ItemsCount::new(TRIANGLES)).bench(|| mesh::load(&path, &()).map(|loaded| loaded.file_vertex_count));
}

#[divan::bench(args = FILES, sample_count = 3, sample_size = 1)]
fn save(bencher: Bencher, name: &str) {
    let path = FOLDER.path().join(format!("new-{name}"));
    let mesh = torus(name.starts_with("smooth"));
    let format = MeshFormat::from_path(&path, name.starts_with("text")).expect("a form of meshes");
    bencher.counter(ItemsCount::new(TRIANGLES)).bench(|| mesh.write(&path, format, &[]));
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn merge_equal_vertices(bencher: Bencher) {
    bencher.counter(ItemsCount::new(TRIANGLES)).with_inputs(|| torus(false)).bench_values(|mut mesh| {
        mesh.merge_equal_vertices();
        mesh
    });
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn report(bencher: Bencher) {
    let mesh = torus(false);
    bencher.counter(ItemsCount::new(TRIANGLES)).bench(|| mesh.mesh_report());
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn compute_smooth_normals(bencher: Bencher) {
    bencher.counter(ItemsCount::new(TRIANGLES)).with_inputs(|| torus(false)).bench_values(|mut mesh| {
        mesh.compute_missing_smooth_normals(30.0);
        mesh
    });
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn repair(bencher: Bencher) {
    let all = MeshRepairOptions {
        weld_tolerance: Some(1e-9),
        removes_duplicates: true,
        removes_degenerates: true,
        orients_outward: true,
    };
    bencher.counter(ItemsCount::new(TRIANGLES)).with_inputs(|| torus(false)).bench_values(|mut mesh| {
        mesh.repair(&all);
        mesh
    });
}

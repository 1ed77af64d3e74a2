//! How fast scene text is read: to directives, and on to the description of a scene.
//!
//! `cargo bench --bench parse`; the figures are in bytes of text a second.

use bhs::lang::parse::Directives;
use bhs::lang::{SourceMap, resolve};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::fmt::Write;
use std::hint::black_box;

/// One mesh with its numbers in the text.
fn mesh(vertices: usize) -> String {
    let mut text = String::from("WorldBegin\nShape \"trianglemesh\" \"point3 P\" [\n");
    for i in 0..vertices {
        let t = i as f64 * 0.001;
        let _ = writeln!(text, "{:.6} {:.6} {:.6}", t.sin(), t.cos(), t);
    }
    text += "] \"integer indices\" [\n";
    for i in 2..vertices {
        let _ = writeln!(text, "{} {} {}", i - 2, i - 1, i);
    }
    text + "]\n"
}

/// Many small directives, as exporters write them.
fn directives(count: usize) -> String {
    let mut text = String::from("WorldBegin\n");
    for i in 0..count {
        let x = i as f64 * 0.01;
        let _ = write!(
            text,
            "AttributeBegin\n  Translate {x:.3} 0 {:.3}\n  Material \"diffuse\" \"rgb reflectance\" [ 0.8 0.4 0.1 ]\n  \
             Shape \"sphere\" \"float radius\" 0.25\nAttributeEnd\n",
            -x
        );
    }
    text
}

fn parse(c: &mut Criterion) {
    let mut group = c.benchmark_group("parse");
    group.sample_size(20);
    for (name, text) in [("mesh", mesh(50_000)), ("directives", directives(10_000))] {
        group.throughput(Throughput::Bytes(text.len() as u64));
        group.bench_function(format!("{name}/directives"), |b| b.iter(|| Directives::new(black_box(&text), 0).count()));
        group.bench_function(format!("{name}/by the grammar alone"), |b| {
            b.iter(|| Directives::by_grammar(black_box(&text), 0).count());
        });
        group.bench_function(format!("{name}/description"), |b| {
            b.iter(|| {
                let mut sources = SourceMap::new();
                let file = sources.add("bench", &text);
                resolve::resolve(&mut sources, file)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, parse);
criterion_main!(benches);

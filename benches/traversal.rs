//! Rays per second: our acceleration structure beside Embree and obvhs's own traversals, on the same rays in turns.
//!
//! `cargo bench -p mlt-benches --bench traversal`; name scenes to leave out the others, `… -- interior`. Embree is loaded
//! where there is one, else left out with a sentence on standard error.

use mlt_benches::embree::{Embree, EmbreeScene};
use mlt_benches::rays::{Kind, compare};
use mlt_benches::stage::Stage;
use mlt_benches::tracer::{Obvhs, Tracer};
use mlt_core::transport::accel::Accel;

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with('-')).collect();
    let embree = Embree::load();
    println!("ours: M rays/s on one thread; the others: ours over theirs");
    for stage in Stage::all().map(|stage| stage()) {
        if !wanted.is_empty() && !wanted.iter().any(|name| name == stage.name) {
            continue;
        }
        let ours = Accel::new(&stage.triangles);
        let mut others: Vec<(String, Box<dyn Tracer>)> = vec![
            ("obvhs bvh2".into(), Box::new(Obvhs::binary(&stage.triangles))),
            ("obvhs cwbvh".into(), Box::new(Obvhs::wide(&stage.triangles))),
        ];
        for (embree, robust) in embree.iter().flat_map(|&embree| [(embree, true), (embree, false)]) {
            let name = format!("{}{}", embree.name(), if robust { " robust" } else { "" });
            others.push((name, Box::new(EmbreeScene::new(embree, &stage.triangles, robust))));
        }
        let tracers: Vec<&dyn Tracer> = others.iter().map(|(_, tracer)| tracer.as_ref()).collect();
        for kind in Kind::ALL {
            let cell = compare(kind, &kind.rays(&stage, &ours), &ours, &tracers);
            print!("{:8} {:10} ours {:6.2}", stage.name, kind.name(), cell.rate / 1e6);
            others.iter().zip(&cell.ratios).for_each(|((name, _), ratio)| print!("   {name} {ratio:.2}"));
            println!();
        }
    }
}

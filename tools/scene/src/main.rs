//! Makes tiled scenes with known holes, and digs holes into real ones.
#![allow(clippy::print_stdout, reason = "the command line prints its results")]

mod args;

use anyhow::Result;
use args::{Args, Verb};
use clap::Parser;
use scene::dig::dig;
use scene::make::{Summary, make};
use scene::maker::Maker;

fn main() -> Result<()> {
    match Args::parse().verb {
        Verb::Make(args) => {
            let maker = Maker::new(args.options())?;
            print_summary(&make(&maker, &args.out)?);
        }
        Verb::Dig(args) => {
            let summary = dig(&args.scene, &args.out, &args.options())?;
            println!(
                "{} of {} tiles dug, {} vertices lost",
                summary.changed_tiles, summary.tiles, summary.lost_vertices
            );
            println!("faces taken by each disc: {:?}", summary.removed);
        }
    }
    Ok(())
}

fn print_summary(summary: &Summary) {
    println!(
        "{} tiles in {} cells, {} triangles, {} bytes",
        summary.tiles, summary.cells, summary.triangles, summary.bytes
    );
    for (class, count) in &summary.counts {
        println!("{class:>8} {count}");
    }
}

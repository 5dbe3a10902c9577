//! Makes tiled scenes with known holes.
#![allow(clippy::print_stdout, reason = "the command line prints its results")]

mod args;

use anyhow::Result;
use args::{Args, Verb};
use clap::Parser;
use scene::make::{Summary, make};
use scene::maker::Maker;

fn main() -> Result<()> {
    match Args::parse().verb {
        Verb::Make(args) => {
            let maker = Maker::new(args.options())?;
            print_summary(&make(&maker, &args.out)?);
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

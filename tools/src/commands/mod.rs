//! The subcommands, one file each. A new one is a file with a [`clap::Args`] struct that implements [`Run`], its `mod` line, and one line in
//! `commands!`.

mod at;
mod bake;
mod bench;
mod building;
mod compare;
mod drawing;
mod edit;
mod exporting;
mod film;
mod fly;
mod gallery;
mod gpus;
mod growth;
mod height;
mod info;
mod look_options;
mod mesh;
mod output;
mod packing;
mod paths;
mod pictures;
mod planets;
mod publish;
mod radiance;
mod raster;
mod recipes;
mod record;
mod region;
mod serve;
mod shot;
mod simplify;
mod stage_times;
mod still;
mod strip;
mod study;
mod tiles;
mod verify;
mod viewing;
mod views;

use crate::Outcome;

/// A subcommand with its arguments.
pub(crate) trait Run {
    /// Does it. Results go to stdout, everything else to stderr.
    fn run(self) -> anyhow::Result<Outcome>;
}

macro_rules! commands {
    ($($file:ident => $name:ident),* $(,)?) => {
        /// All subcommands; their help is that of their argument structs.
        #[derive(clap::Subcommand)]
        pub(crate) enum Command {
            $(#[allow(missing_docs, reason = "a doc comment here would replace the help text")] $name($file::$name),)*
        }

        impl Command {
            /// Runs the one that was given.
            pub(crate) fn run(self) -> anyhow::Result<Outcome> {
                match self { $(Command::$name(command) => command.run(),)* }
            }
        }
    };
}

commands! {
    bake => Bake,
    bench => Bench,
    compare => Compare,
    edit => Edit,
    fly => Fly,
    gallery => Gallery,
    gpus => Gpus,
    growth => Growth,
    height => Height,
    info => Info,
    mesh => Mesh,
    publish => Publish,
    raster => Raster,
    record => Record,
    serve => Serve,
    shot => Shot,
    simplify => Simplify,
    study => Study,
    tiles => Tiles,
    verify => Verify,
}

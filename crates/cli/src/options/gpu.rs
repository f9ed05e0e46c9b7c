use clap::Args;

use super::look::{Drawn, LookArgs};

/// How the GPU draws. What is not given is the scene file's, or else the default.
#[derive(Args, Clone, Debug)]
pub struct GpuArgs {
    #[command(flatten)]
    pub look: LookArgs<Drawn>,

    /// Part of the name of the adapter to use (see gnomon info) [default: the fastest]
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
}

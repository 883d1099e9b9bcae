//! `terrane gpus`: the GPUs of this machine.

use super::Run;
use crate::Outcome;
use serde_json::json;
use terrane::vulkan::{list_gpus, GpuInfo};

/// List the GPUs of this machine, and what keeps a GPU from being used.
#[derive(clap::Args)]
pub(crate) struct Gpus {
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Run for Gpus {
    fn run(self) -> anyhow::Result<Outcome> {
        let gpus = list_gpus()?;
        if self.json {
            println!("{}", json!({ "gpus": gpus.iter().map(entry).collect::<Vec<_>>() }));
            return Ok(Outcome::Done);
        }
        for gpu in &gpus {
            println!("{}: {} ({})", gpu.index, gpu.name, gpu.kind.as_str());
            println!("   UUID {}", gpu.uuid);
            println!("   driver {} {}, Vulkan {}", gpu.driver, gpu.driver_info, gpu.api_version);
            match gpu.unusable.as_slice() {
                [] => println!("   usable, subgroups of {}", subgroups(gpu)),
                lacks => println!("   not usable: it lacks {}", lacks.join(", ")),
            }
        }
        Ok(Outcome::Done)
    }
}

fn subgroups(gpu: &GpuInfo) -> String {
    match gpu.subgroup_sizes {
        [least, most] if least < most => format!("{}, or {least} to {most}", gpu.subgroup_size),
        _ => gpu.subgroup_size.to_string(),
    }
}

fn entry(gpu: &GpuInfo) -> serde_json::Value {
    json!({
        "index": gpu.index, "name": gpu.name, "kind": gpu.kind.as_str(), "uuid": gpu.uuid, "driver": gpu.driver, "driver_info": gpu.driver_info,
        "api_version": gpu.api_version, "subgroup_size": gpu.subgroup_size, "subgroup_sizes": gpu.subgroup_sizes, "usable": gpu.unusable.is_empty(),
        "lacks": gpu.unusable,
    })
}

//! `terrane shot`: one still picture.

use super::viewing::{Exposure, CameraOptions, GpuOptions, LookOptions, MeshOptions, PatchOptions};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::Context as _;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;
use terrane::frame::STAGES;
use terrane::headless::{FrameReport, Headless};
use terrane::scene::Scene;
use terrane_planet::view::View;

/// Render one picture of a planet without a window.
#[derive(clap::Args)]
pub(crate) struct Shot {
    /// Planet file.
    file: PathBuf,
    #[command(flatten)]
    camera: CameraOptions,
    #[command(flatten)]
    mesh: MeshOptions,
    #[command(flatten)]
    patches: PatchOptions,
    #[command(flatten)]
    look: LookOptions,
    /// PNG to write.
    #[arg(long)]
    out: PathBuf,
    #[command(flatten)]
    gpu: GpuOptions,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Run for Shot {
    fn run(self) -> anyhow::Result<Outcome> {
        let begun = Instant::now();
        let context = self.gpu.context()?;
        let mut scene = Scene::open(&context, &self.file, self.patches.options()?)?;
        let camera = self.camera.camera(scene.planet())?;
        let view = self.mesh.apply(View::new(camera, scene.lattice(), scene.planet().cells, self.camera.error), scene.planet());
        let look = self.look.look(&scene.planet().recipe, self.camera.place(), Exposure::Fixed(1.0));
        scene.set_sun(look.sun);
        let cut = scene.settle(&view)?;
        let [width, height] = camera.size;
        let mut headless = Headless::new(&context, (width, height))?;
        let settled = Instant::now();
        let report = headless.render(&scene, &view, &cut, &look)?;
        let frame_ms = settled.elapsed().as_secs_f64() * 1e3;
        pictures::write_png(&self.out, camera.size, &headless.pixels()?)
            .with_context(|| format!("cannot write the picture {}", self.out.display()))?;
        let ready_ms = settled.duration_since(begun).as_secs_f64() * 1e3;
        if self.json {
            let info = context.device_info();
            println!("{}", summary(&report, info, &self.out, frame_ms, ready_ms, &scene));
        } else {
            println!(
                "{}: {} patches ({} of {} on the GPU built), {} awake vertices, {} triangles, {frame_ms:.0} ms",
                self.out.display(),
                report.tables.patches.len(),
                scene.tally().built,
                scene.resident_count(),
                report.counters.awake,
                report.counters.wanted
            );
        }
        self.gpu.report_messages(&context)?;
        Ok(Outcome::Done)
    }
}

fn summary(
    report: &FrameReport,
    gpu: &terrane::vulkan::GpuInfo,
    out: &std::path::Path,
    frame_ms: f64,
    ready_ms: f64,
    scene: &Scene,
) -> serde_json::Value {
    let stages: serde_json::Map<_, _> =
        STAGES.iter().filter_map(|stage| Some(((*stage).to_owned(), json!(report.times.ms(stage)?)))).collect();
    json!({
        "picture": out, "device": gpu.name, "driver": gpu.driver, "driver_info": gpu.driver_info,
        "patches": report.tables.patches.len(), "awake_vertices": report.counters.awake,
        "prefix_vertices": report.tables.vertices, "candidate_triangles": report.tables.triangles,
        "triangles": report.counters.wanted, "dropped_triangles": report.counters.wanted.saturating_sub(report.counters.capacity),
        "patches_read": scene.tally().read, "patches_built": scene.tally().built, "build_s": scene.tally().build_s,
        "resident_patches": scene.resident_count(), "patch_bytes_on_gpu": scene.gpu_bytes().0, "patch_bytes_on_host": scene.host_bytes().0, "settled": scene.is_settled(),
        "stages_gpu_ms": stages, "gpu_wall_ms": report.times.wall_ms, "frame_ms": frame_ms, "ready_ms": ready_ms,
    })
}

//! `terrane shot`: one still picture.

use super::building::Report;
use super::drawing::{first_picture, DrawOptions};
use super::output::{check_output, Output};
use super::planets::{planet_file, FILE, WITH_VIEW};
use super::radiance::{write_exr, Taken};
use super::stage_times::stage_times;
use super::still::{format_of, StillArguments};
use super::viewing::{CameraOptions, Exposure};
use super::views::{check_planet, given, note_planet, HELP, VALUE};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::Context as _;
use serde_json::{json, Value};
use std::path::PathBuf;
use std::time::Instant;
use terrane::frame::PerStage;
use terrane::scene::Scene;
use terrane::stills::{PixelFormat, Still, Studio};
use terrane::vulkan::GpuInfo;
use terrane_planet::draw::view_line::ViewLine;
use terrane_planet::planet::Planet;
use terrane_planet::published::Fetched;

/// Render one picture of a planet without a window.
///
/// Pictures may be larger than the device's images: they are drawn by tiles of one mesh, selected for the whole picture.
#[derive(clap::Args)]
pub(crate) struct Shot {
    #[arg(value_name = FILE, help = WITH_VIEW)]
    file: Option<PathBuf>,
    #[arg(long, value_name = VALUE, value_parser = given, help = HELP)]
    view: Option<ViewLine>,
    #[command(flatten)]
    camera: CameraOptions,
    #[command(flatten)]
    draw: DrawOptions,
    #[command(flatten)]
    still: StillArguments,
    /// Bits a channel of a PNG, 8 or 16.
    #[arg(long, value_name = "BITS")]
    depth: Option<u32>,
    /// Picture to write: a .png, encoded for displays, with its view as text, which --view takes; or an .exr, which holds radiance in linear light before exposure as half floats,
    /// with exposure, tone curve, camera and sun in its header.
    #[arg(long, value_name = "x.png|x.exr")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Run for Shot {
    fn run(mut self) -> anyhow::Result<Outcome> {
        let begun = Instant::now();
        if let Some(line) = &self.view {
            self.camera.take(line);
            self.draw.take(line);
            self.still.take(line);
            self.depth = self.depth.or(line.depth);
        }
        let format = format_of(&self.out, self.depth)?;
        check_output("--out", &self.out, Output::File(&["png", "exr"]))?;
        let place = planet_file(self.file.as_deref(), self.view.as_ref())?;
        let (context, mut scene) = self.draw.open(&place)?;
        self.view.iter().for_each(|line| check_planet(line, scene.planet()));
        let camera = self.camera.camera(scene.planet())?;
        let view = self.draw.view(camera, scene.planet(), self.camera.error());
        let look = self.draw.look.look(&scene.planet().recipe, self.camera.site(&scene.planet().recipe)?, Exposure::Fixed(1.0));
        scene.set_sun(look.sun);
        first_picture(&mut scene, &view)?;
        let first_ms = begun.elapsed().as_secs_f64() * 1e3;
        let waiting = Report::counting("patches", "so far");
        let cut = scene.settle_showing(&view, &mut |there, pending| waiting.step(there, there + pending, begun.elapsed()))?;
        waiting.finish();
        let mut studio = Studio::new(&context, camera.size, self.still.options(format))?;
        studio.set_time(self.camera.time());
        let settled = Instant::now();
        let report = Report::counting("picture", "tiles");
        let show = |done, tiles| {
            if tiles > 1 {
                report.step(done, tiles, settled.elapsed())
            }
        };
        let still = studio.draw(&scene, &view, &cut, &look, &show)?;
        report.finish();
        let frame_ms = settled.elapsed().as_secs_f64() * 1e3;
        let recipe = &scene.planet().recipe;
        let line = self.line(scene.planet(), format)?;
        self.write(&still, &line, &Taken { planet: &recipe.name, radius: recipe.radius, camera: &camera, sun: look.sun })
            .with_context(|| format!("cannot write the picture {}", self.out.display()))?;
        let ready_ms = settled.duration_since(begun).as_secs_f64() * 1e3;
        if self.json {
            let mut summary = self.summary(&still, &line, context.device_info(), &Times { first_ms, ready_ms, frame_ms }, &scene);
            if let Some(published) = place.published() {
                summary["fetched"] = fetched_json(&published.fetched());
            }
            println!("{summary}");
        } else {
            println!(
                "{}: {} patches ({} of {} on the GPU built), {} awake vertices, {} triangles, {frame_ms:.0} ms; \
                 coarse after {first_ms:.0} ms, settled after {ready_ms:.0} ms",
                self.out.display(),
                still.report.tables.patches.len(),
                scene.tally().built,
                scene.resident_count(),
                still.report.counters.awake,
                still.report.counters.wanted
            );
        }
        self.draw.gpu.report_messages(&context)?;
        Ok(Outcome::Done)
    }
}

fn fetched_json(fetched: &Fetched) -> Value {
    let (requests, network_bytes) = fetched.traffic;
    json!({
        "segments": fetched.segments, "bytes": fetched.bytes, "whole_bytes": fetched.whole_bytes, "refused": fetched.refused, "failed": fetched.failed, "requests": requests,
        "network_bytes": network_bytes,
    })
}

/// Milliseconds from the start of the command until a whole picture could be drawn, however coarse, and until nothing was missing; and
/// those of drawing.
struct Times {
    first_ms: f64,
    ready_ms: f64,
    frame_ms: f64,
}

impl Shot {
    /// What decides the picture.
    fn line(&self, planet: &Planet, format: PixelFormat) -> anyhow::Result<ViewLine> {
        let mut line = self.camera.line(planet)?;
        note_planet(&mut line, planet);
        self.draw.note(&mut line, Exposure::Fixed(1.0));
        self.still.note(&mut line);
        line.depth = (format == PixelFormat::Sixteen).then_some(16);
        Ok(line)
    }

    fn write(&self, still: &Still, line: &ViewLine, taken: &Taken) -> anyhow::Result<()> {
        match format_of(&self.out, self.depth)? {
            PixelFormat::Radiance => write_exr(&self.out, still, taken),
            PixelFormat::Eight | PixelFormat::Sixteen => pictures::write_still_of(&self.out, still, line),
        }
    }

    fn summary(&self, still: &Still, line: &ViewLine, gpu: &GpuInfo, times: &Times, scene: &Scene) -> serde_json::Value {
        let report = &still.report;
        let Times { first_ms, ready_ms, frame_ms } = times;
        json!({
            "picture": self.out, "view": line.to_string(), "size": still.size, "tiles": still.tiles, "ssaa": self.still.ssaa(), "exposure": still.exposure,
            "tone": still.curve.tone.name(), "white": still.curve.white,
            "device": gpu.name, "driver": gpu.driver, "driver_info": gpu.driver_info,
            "patches": report.tables.patches.len(), "awake_vertices": report.counters.awake,
            "prefix_vertices": report.tables.vertices, "candidate_triangles": report.tables.triangles,
            "triangles": report.counters.wanted, "dropped_triangles": still.dropped_triangles,
            "patches_read": scene.tally().read, "patches_surveyed": scene.tally().surveyed, "patches_built": scene.tally().built, "build_s": scene.tally().build_s,
            "resident_patches": scene.resident_count(), "patch_bytes_on_gpu": scene.gpu_bytes().0,
            "patch_bytes_on_host": scene.host_bytes().0, "settled": scene.is_settled(),
            "stages_gpu_ms": stage_times(&PerStage::gpu_ms(&report.times)), "gpu_wall_ms": report.times.wall_ms, "frame_ms": frame_ms,
            "first_picture_ms": first_ms, "settled_ms": ready_ms, "ready_ms": ready_ms,
        })
    }
}

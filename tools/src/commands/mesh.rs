//! `terrane mesh`: the triangles of a view, for other programs.

use super::exporting::{write_sidecar, ExportOptions};
use super::output::{check_output, Output};
use super::planets::{built_planet_file, FILE, WITH_VIEW};
use super::viewing::CameraOptions;
use super::views::{check_planet, given, HELP, VALUE};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::Context as _;
use glam::IVec3;
use serde_json::json;
use std::path::PathBuf;
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::View;
use terrane_planet::draw::view_line::ViewLine;
use terrane_planet::export::{origin_near, view_surface, Format, Placed, EXTENSIONS};
use terrane_planet::planet::Planet;
use terrane_planet::store::PlanetFile;

/// Where coordinates start from.
#[derive(clap::ValueEnum, Clone, Copy)]
enum Centre {
    /// A lattice point next to the camera.
    View,
    /// The planet's centre.
    Planet,
}

/// Write the mesh of a view, exactly the triangles that would be drawn. Needs no GPU.
///
/// Patches are those of the planet file. Of a recipe it holds two levels, and what was built in pictures and flights.
///
/// OBJ, PLY and 3MF hold planet-fixed metres without any rounding (+Z north, +X longitude 0; see --up). GLB and STL hold single precision,
/// GLB in glTF's axes: planet (x, y, z) becomes (x, z, -y). Its positions count from a lattice point next to the camera, which the node's
/// translation and extras hold exactly; they are off by at most a 2^-25th of their size: 0.03 mm at 1 km from the camera.
#[derive(clap::Args)]
pub(crate) struct Mesh {
    #[arg(value_name = FILE, help = WITH_VIEW)]
    file: Option<PathBuf>,
    #[arg(long, value_name = VALUE, value_parser = given, help = HELP)]
    view: Option<ViewLine>,
    #[command(flatten)]
    camera: CameraOptions,
    /// Keep what the camera does not see: one closed surface around the planet.
    #[arg(long)]
    whole: bool,
    /// Where coordinates start from [default: view for GLB and STL, planet for the others].
    #[arg(long, value_enum)]
    centre: Option<Centre>,
    #[command(flatten)]
    export: ExportOptions,
    #[arg(long, help = format!("File to write: {EXTENSIONS}"))]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Run for Mesh {
    fn run(mut self) -> anyhow::Result<Outcome> {
        let format = Format::of(&self.out)?;
        self.export.check(format)?;
        check_output("--out", &self.out, Output::File(&[]))?;
        let place = built_planet_file(self.file.as_deref(), self.view.as_ref())?;
        self.export.check_sidecar(&self.out, &[place.path().to_owned()])?;
        let file = PlanetFile::open(place.path())?;
        let planet = Planet::from_header(file.header())?;
        if let Some(line) = &self.view {
            check_planet(line, &planet);
            self.camera.take(line);
        }
        let tree = planet.tree(file.index()?.iter().filter(|r| r.has_mesh()).map(|r| (r.id, r.facts)));
        let view = View::new(self.camera.camera(&planet)?, &planet.lattice, planet.cells, self.camera.error());
        let surface = view_surface(&tree, &view, self.whole, |id| file.mesh(id).map(|m| LoadedPatch::new(m, &planet.lattice)))?;
        let origin = match (self.centre, format) {
            (Some(Centre::View), _) | (None, Format::Glb | Format::Stl) => origin_near(view.gpu.anchor),
            (Some(Centre::Planet), _) | (None, _) => IVec3::ZERO,
        };
        let placed = Placed { surface: &surface, origin, lattice: planet.lattice };
        let model = match (self.export.solid, self.export.maps) {
            (Some(below), _) => placed.solid(below),
            (None, Some(side)) => placed.model_with_maps(&planet.ground(), &planet.terrain, side)?,
            (None, None) => placed.model_with_normals(&planet.ground()),
        };
        // With maps vertices are there once a patch, which opens no edge of the surface.
        let open_edges = if self.export.solid.is_some() { model.open_edges() } else { surface.open_edges() };
        let made = Made { triangles: model.triangle_count(), vertices: model.vertex_count(), open_edges };
        let sidecar = self.export.sidecar(&model, format)?;
        let bytes = self.export.encode(model, format)?;
        pictures::write_whole(&self.out, &bytes).with_context(|| format!("cannot write the mesh {}", self.out.display()))?;
        sidecar.map_or(Ok(()), |sidecar| write_sidecar(&self.out, &sidecar))?;
        self.print(&placed, &made, format, bytes.len(), &view)?;
        Ok(Outcome::Done)
    }
}

/// What a file holds.
struct Made {
    triangles: usize,
    vertices: usize,
    open_edges: usize,
}

impl Mesh {
    fn print(&self, placed: &Placed, made: &Made, format: Format, bytes: usize, view: &View) -> anyhow::Result<()> {
        let (patches, largest) = (placed.surface.parts.len(), placed.largest_coordinate());
        let &Made { triangles, vertices, open_edges } = made;
        if self.json {
            let summary = json!({
                "mesh": self.out, "format": format.name(), "triangles": triangles, "vertices": vertices, "patches": patches,
                "closed": open_edges == 0, "open_edges": open_edges, "largest_coordinate_m": largest, "bytes": bytes,
                "origin_lattice": placed.origin.to_array(), "unit_m": placed.lattice.unit, "georeference": placed.origin().json(),
                "scale": view.scale, "up": self.export.up_name(format)?, "solid": self.export.solid.is_some(),
            });
            println!("{summary}");
            return Ok(());
        }
        let closed = if open_edges == 0 { "closed".to_owned() } else { format!("{open_edges} open edges") };
        println!(
            "{}: {triangles} triangles, {vertices} vertices from {patches} patches, {closed}, coordinates up to {largest} m, {:.1} MB",
            self.out.display(),
            bytes as f64 / 1e6
        );
        Ok(())
    }
}

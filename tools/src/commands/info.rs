//! `terrane info`: what a planet file holds.

use super::edit::edit_json;
use super::Run;
use crate::Outcome;
use serde_json::{json, Value};
use std::path::PathBuf;
use terrane_planet::globe::sphere::latitude_longitude;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Place;
use terrane_planet::store::{PatchRecord, PlanetFile, FORMAT_VERSION};

/// Say what a planet file holds.
#[derive(clap::Args)]
pub(crate) struct Info {
    /// Planet file.
    file: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Patches of one level.
struct Level {
    level: u8,
    /// Those with a mesh.
    patches: u64,
    /// Those of which only the texture is there, beside the facts.
    textured: u64,
    /// Those of which only the facts are there.
    surveyed: u64,
    whole: u64,
    geometry: u64,
    texture: u64,
}

fn levels(index: &[PatchRecord]) -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::new();
    for record in index {
        if levels.last().is_none_or(|l| l.level != record.id.level) {
            let level = record.id.level;
            let whole = 6 << (2 * level);
            levels.push(Level { level, patches: 0, textured: 0, surveyed: 0, whole, geometry: 0, texture: 0 });
        }
        if let Some(level) = levels.last_mut() {
            match (record.has_mesh(), record.has_texture()) {
                (true, _) => level.patches += 1,
                (false, true) => level.textured += 1,
                (false, false) => level.surveyed += 1,
            }
            level.geometry += u64::from(record.geometry_bytes);
            level.texture += u64::from(record.texture_bytes);
        }
    }
    levels
}

fn place_json(place: &Place) -> Value {
    json!({
        "name": place.name, "latitude": place.latitude_deg, "longitude": place.longitude_deg, "altitude_m": place.altitude_m,
        "heading": place.heading_deg, "pitch": place.pitch_deg,
    })
}

impl Run for Info {
    fn run(self) -> anyhow::Result<Outcome> {
        let file = PlanetFile::open(&self.file)?;
        let (header, levels, regions) = (file.header(), levels(&file.index()?), file.regions()?);
        let (planet, pending) = (Planet::from_header(header)?, file.pending()?);
        let sum = |count: fn(&Level) -> u64| levels.iter().map(count).sum::<u64>();
        let [patches, textured, surveyed] = [sum(|l| l.patches), sum(|l| l.textured), sum(|l| l.surveyed)];
        let vertices = patches * u64::from(header.cells + 1).pow(2);
        let [geometry, texture] = [sum(|l| l.geometry), sum(|l| l.texture)];
        let bytes_per_vertex = geometry as f64 / vertices.max(1) as f64;
        if self.json {
            let level = |l: &Level| {
                json!({ "level": l.level, "patches": l.patches, "textures_only": l.textured,
                    "surveyed_only": l.surveyed, "whole_planet": l.whole, "geometry_bytes": l.geometry, "texture_bytes": l.texture })
            };
            let region = |r: &terrane_planet::store::Region| {
                let (latitude, longitude) = latitude_longitude(r.direction);
                json!({ "latitude": latitude, "longitude": longitude, "radius_km": r.radius_m / 1e3, "to_level": r.to_level })
            };
            let info = json!({
                "name": header.name, "format_version": FORMAT_VERSION, "radius_m": planet.recipe.radius, "cells": header.cells,
                "lattice_unit_m": header.lattice.unit, "lowest_m": header.height_range[0], "highest_m": header.height_range[1],
                "patches": patches, "textures_only": textured, "surveyed_only": surveyed, "vertices": vertices, "geometry_bytes": geometry, "texture_bytes": texture,
                "bytes_per_vertex": bytes_per_vertex, "levels": levels.iter().map(level).collect::<Vec<_>>(),
                "edits": planet.recipe.edits.iter().map(edit_json).collect::<Vec<_>>(), "pending": pending.len(),
                "places": planet.recipe.places.iter().map(place_json).collect::<Vec<_>>(),
                "regions": regions.iter().map(region).collect::<Vec<_>>(),
            });
            println!("{info}");
            return Ok(Outcome::Done);
        }
        println!("{}: format version {FORMAT_VERSION}", header.name);
        println!(
            "radius {} m, lattice unit {} m, {} cells along a patch side",
            planet.recipe.radius, header.lattice.unit, header.cells
        );
        println!("terrain within {:.0} m and {:.0} m", header.height_range[0], header.height_range[1]);
        println!("{patches} patches, geometry {geometry} bytes ({bytes_per_vertex:.2} a vertex), texture {texture} bytes");
        for l in &levels {
            println!("  level {:2}: {} of {} patches", l.level, l.patches, l.whole);
        }
        if textured + surveyed > 0 {
            println!("beside them {surveyed} patches surveyed only, {textured} with textures only");
        }
        for region in &regions {
            let (latitude, longitude) = latitude_longitude(region.direction);
            println!("region {latitude:.4}, {longitude:.4}: {} km, to level {}", region.radius_m / 1e3, region.to_level);
        }
        for place in &planet.recipe.places {
            let Place { name, latitude_deg, longitude_deg, altitude_m, heading_deg, pitch_deg } = place;
            println!("place {name}: --at {latitude_deg},{longitude_deg},{altitude_m} --look {heading_deg},{pitch_deg}");
        }
        for edit in &planet.recipe.edits {
            println!("edit: {edit}");
        }
        if !pending.is_empty() {
            println!("unfinished: {} patches to build again, with 'terrane edit {} resume'", pending.len(), self.file.display());
        }
        Ok(Outcome::Done)
    }
}

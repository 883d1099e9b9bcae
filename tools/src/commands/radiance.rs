//! OpenEXR pictures: radiance in linear light, as half floats.
//!
//! Colours are those of the scene, before exposure; where there is alpha they are multiplied by it, as the format wants. What the picture
//! was taken with stands in the header.

use super::pictures::write_whole_with;
use anyhow::bail;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage};
use glam::DVec3;
use half::f16;
use std::path::Path;
use terrane::stills::{Pixels, Still};
use terrane_planet::draw::view::Camera;
use terrane_planet::globe::sphere::latitude_longitude;

/// What a picture was taken with.
pub(crate) struct Taken<'a> {
    /// Name of the planet.
    pub(crate) planet: &'a str,
    /// Its radius in metres.
    pub(crate) radius: f64,
    /// The camera.
    pub(crate) camera: &'a Camera,
    /// Towards the sun.
    pub(crate) sun: DVec3,
}

/// Writes a still as OpenEXR.
pub(crate) fn write_exr(path: &Path, still: &Still, taken: &Taken) -> anyhow::Result<()> {
    let Pixels::Radiance(pixels) = &still.pixels else { bail!("a picture of codes is no radiance; please report this") };
    let width = still.size[0] as usize;
    let channel = |at: Vec2<usize>, k: usize| -> f16 { pixels[4 * (at.y() * width + at.x()) + k] };
    let size = (width, still.size[1] as usize);
    let attributes = attributes(still, taken);
    write_whole_with(path, |file| {
        let encoding = Encoding::SMALL_LOSSLESS;
        if still.transparent {
            let rgba = SpecificChannels::rgba(|at| (channel(at, 0), channel(at, 1), channel(at, 2), channel(at, 3)));
            Image::from_layer(Layer::new(size, attributes, encoding, rgba)).write().to_buffered(file)?;
        } else {
            let rgb = SpecificChannels::rgb(|at| (channel(at, 0), channel(at, 1), channel(at, 2)));
            Image::from_layer(Layer::new(size, attributes, encoding, rgb)).write().to_buffered(file)?;
        }
        Ok(())
    })
}

fn attributes(still: &Still, taken: &Taken) -> LayerAttributes {
    let camera = taken.camera;
    let vector = |v: DVec3| AttributeValue::FloatVec3(v.as_vec3().into());
    let (latitude, longitude) = latitude_longitude(camera.position);
    let mut attributes = LayerAttributes {
        software_name: Some(Text::from(concat!("terrane ", env!("CARGO_PKG_VERSION")))),
        comments: Some(Text::from(
            "linear radiance before exposure; planet-fixed axes: z north, x at longitude 0; metres, degrees",
        )),
        latitude: Some(latitude as f32),
        longitude: Some(longitude as f32),
        // The format's word for a height above the datum.
        altitude: Some((camera.position.length() - taken.radius) as f32),
        ..LayerAttributes::default()
    };
    let own = [
        ("planet", AttributeValue::Text(Text::new_or_none(taken.planet).unwrap_or_default())),
        ("displayExposure", AttributeValue::F32(still.exposure)),
        ("displayTone", AttributeValue::Text(Text::new_or_none(still.curve.tone.name()).unwrap_or_default())),
        ("displayWhite", AttributeValue::F32(still.curve.white)),
        ("cameraForward", vector(camera.forward)),
        ("cameraUp", vector(camera.up)),
        ("cameraVerticalFieldOfView", AttributeValue::F32(camera.fov.to_degrees() as f32)),
        ("sunDirection", vector(taken.sun)),
    ];
    attributes.other.extend(own.into_iter().map(|(name, value)| (Text::from(name), value)));
    attributes
}

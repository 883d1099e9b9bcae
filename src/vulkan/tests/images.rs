//! Images: round trips of layers, levels and formats, storage images, limits.

use super::device;
use crate::shaders::test::SQUARE_COMP;
use crate::vulkan::{
    capture, vk, Access, Commands, ComputePipeline, Image, ImageDescription, Resource, Sampler, SamplerDescription, Upload,
};

#[test]
fn every_layer_and_level_comes_back_as_it_was_uploaded() {
    let Some(context) = device() else { return };
    let sampled = vk::ImageUsageFlags::SAMPLED;
    let formats = [(vk::Format::R8G8B8A8_UNORM, 4), (vk::Format::R16G16B16A16_SFLOAT, 8), (vk::Format::R32_SFLOAT, 4)];
    for (format, texel) in formats {
        let mut description = ImageDescription::new("layers", (12, 10), format, sampled);
        (description.layers, description.mips) = (3, 4);
        let image = Image::new(&context, &description).unwrap();
        assert_eq!(image.mip_size(3), (1, 1));
        // Small chunks, so that the batch needs several.
        let mut upload = Upload::new(&context, 256);
        let parts = || (0..3).flat_map(|layer| (0..4).map(move |mip| (layer, mip)));
        let texels = |layer: u32, mip: u32| -> Vec<u8> {
            let (width, height) = image.mip_size(mip);
            let bytes = width * height * texel;
            // Small bytes: no signalling NaN that a conversion might quieten.
            (0..bytes).map(|i| ((i * 7 + layer * 31 + mip * 13) % 61) as u8).collect()
        };
        for (layer, mip) in parts() {
            upload.image(&image, layer, mip, &texels(layer, mip)).unwrap();
        }
        upload.finish().unwrap();
        assert_eq!(upload.staged_bytes(), 0);
        for (layer, mip) in parts() {
            let captured = capture(&context, &image, (layer, mip), Access::Sampled).unwrap();
            assert_eq!(captured.bytes, texels(layer, mip), "{format:?} {layer} {mip}");
        }
    }
}

#[test]
fn compute_reads_a_sampled_image_and_writes_a_storage_image() {
    let Some(context) = device() else { return };
    let format = vk::Format::R32_SFLOAT;
    let image = |name, usage| Image::new(&context, &ImageDescription::new(name, (20, 9), format, usage)).unwrap();
    let source = image("source", vk::ImageUsageFlags::SAMPLED);
    let target = image("target", vk::ImageUsageFlags::STORAGE);
    let values: Vec<f32> = (0..180).map(|i| i as f32 - 90.0).collect();
    let mut upload = Upload::new(&context, 1024);
    upload.image(&source, 0, 0, &values).unwrap();
    let nearest = SamplerDescription { filter: vk::Filter::NEAREST, ..Default::default() };
    let sampler = Sampler::new(&context, "nearest", &nearest).unwrap();
    let pipeline = ComputePipeline::new(&context, &SQUARE_COMP, &[(0, 3)]).unwrap();
    assert_eq!(pipeline.workgroup_size(), [8, 8, 1]);
    Commands::once(&context, "square", |commands| {
        upload.record(commands)?;
        commands.ready(&[target.view().anew(Access::ComputeWrite)])?;
        let resources =
            [("source", Resource::Sampled(source.view(), &sampler)), ("target", Resource::StorageImage(target.view()))];
        commands.bind(&pipeline, &resources)?;
        commands.dispatch(3, 2, 1)
    })
    .unwrap();
    let captured = capture(&context, &target, (0, 0), Access::ComputeWrite).unwrap();
    let expected: Vec<f32> = values.iter().map(|v| v * v * 3.0).collect();
    assert_eq!(captured.to_f32().unwrap(), expected);
}

#[test]
fn images_past_the_limits_are_errors() {
    let Some(context) = device() else { return };
    let format = vk::Format::R8G8B8A8_UNORM;
    let usage = vk::ImageUsageFlags::SAMPLED;
    let good = ImageDescription::new("limits", (16, 16), format, usage);
    let most = context.limits().max_image_array_layers;
    let cases = [
        ImageDescription { layers: most + 1, ..good },
        ImageDescription { layers: 0, ..good },
        ImageDescription { mips: 6, ..good },
        ImageDescription { width: 0, ..good },
    ];
    for description in cases {
        assert!(Image::new(&context, &description).is_err(), "{description:?}");
    }
    let image = Image::new(&context, &good).unwrap();
    assert!(image.layer_view(1, 0).is_err());
    assert!(image.layer_view(0, 1).is_err());
    let mut upload = Upload::new(&context, 1024);
    assert!(upload.image(&image, 0, 0, &[0u8; 17]).is_err(), "too few texels");
    Commands::once(&context, "unknown", |commands| {
        assert!(commands.ready(&[image.view().to(Access::Sampled)]).is_err(), "its contents are undefined");
        Ok(())
    })
    .unwrap();
}

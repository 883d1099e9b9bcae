//! Images: round trips of layers, levels and formats, storage images, limits.

use super::device;
use crate::shaders::test::SQUARE_COMP;
use crate::vulkan::{
    capture, vk, Access, Commands, ComputePipeline, Image, ImageDescription, ImageRegion, Resource, Sampler, SamplerDescription,
    Upload,
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
fn a_region_keeps_the_texels_around_it() {
    let Some(context) = device() else { return };
    let usage = vk::ImageUsageFlags::SAMPLED;
    let description =
        ImageDescription { layers: 2, mips: 2, ..ImageDescription::new("regions", (8, 6), vk::Format::R32_UINT, usage) };
    let image = Image::new(&context, &description).unwrap();
    let mut upload = Upload::new(&context, 1024);
    upload.begin_image(&image, None);
    let region = |layer, mip, origin, size| ImageRegion { layer, mip, origin, size };
    upload.image_region(&image, &region(1, 0, (2, 1), (3, 2)), &[1u32; 6]).unwrap();
    // Overlaps the last, and comes later.
    upload.image_region(&image, &region(1, 0, (4, 2), (4, 4)), &[2u32; 16]).unwrap();
    upload.finish().unwrap();
    upload.image_region(&image, &region(1, 1, (3, 2), (1, 1)), &[3u32]).unwrap();
    upload.finish().unwrap();
    let texels = |layer, mip| -> Vec<u32> {
        let bytes = capture(&context, &image, (layer, mip), Access::Sampled).unwrap().bytes;
        bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    };
    let expected = |x: u32, y: u32| {
        let (first, second) = ((2..5).contains(&x) && (1..3).contains(&y), x >= 4 && y >= 2);
        if second {
            2
        } else {
            u32::from(first)
        }
    };
    let whole: Vec<u32> = (0..6).flat_map(|y| (0..8).map(move |x| expected(x, y))).collect();
    assert_eq!(texels(1, 0), whole);
    assert_eq!((texels(1, 1), texels(0, 0)), ([&[0; 11], [3].as_slice()].concat(), vec![0; 48]));
    for bad in [region(2, 0, (0, 0), (1, 1)), region(0, 1, (3, 0), (2, 1)), region(0, 0, (0, u32::MAX), (1, 1))] {
        assert!(upload.image_region(&image, &bad, &vec![0u32; (bad.size.0 * bad.size.1) as usize]).is_err(), "{bad:?}");
    }
    assert!(upload.image_region(&image, &region(0, 0, (0, 0), (2, 2)), &[0u32; 3]).is_err(), "too few texels");
    // Layers go to an image of the same kind alone.
    let wider = Image::new(&context, &ImageDescription { width: 16, ..description }).unwrap();
    upload.begin_image(&wider, Some(&image));
    assert!(upload.finish().is_err());
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

//! The machine: which GPUs there are, and what is said where there are none.

use std::process::Command;

use super::device;
use crate::vulkan::{list_gpus, Context, ContextOptions, GpuChoice, VulkanError};

#[test]
fn listed_gpus_can_be_chosen_by_index_name_and_uuid() {
    let Some(context) = device() else { return };
    let gpus = list_gpus().unwrap();
    let chosen = context.device_info();
    let listed = &gpus[chosen.index];
    assert_eq!((&listed.name, &listed.driver_info), (&chosen.name, &chosen.driver_info));
    assert!(listed.unusable.is_empty() && listed.api_version.starts_with("1."));
    for text in [chosen.index.to_string(), chosen.name.to_uppercase(), chosen.uuid.clone(), chosen.uuid.replace('-', "")] {
        let options = ContextOptions { gpu: GpuChoice::parse(&text), ..ContextOptions::default() };
        // Twins have one name.
        match Context::new(&options) {
            Ok(context) => assert_eq!((&context.device_info().name, &context.device_info().uuid), (&chosen.name, &chosen.uuid)),
            Err(error) => assert!(matches!(error, VulkanError::SeveralGpus { .. }), "{error:?}"),
        }
    }
}

#[test]
fn a_gpu_that_does_not_exist_is_an_error_that_lists_the_others() {
    let Some(context) = device() else { return };
    for choice in [GpuChoice::Index(99), GpuChoice::Name("no such".to_owned())] {
        let options = ContextOptions { gpu: choice, ..ContextOptions::default() };
        let error = Context::new(&options).err().unwrap();
        assert!(matches!(error, VulkanError::NoSuchGpu { .. }), "{error:?}");
        assert!(error.to_string().contains(&context.device_info().name), "{error}");
    }
}

#[test]
fn subgroups_have_the_size_that_is_asked_for_or_none_is_made() {
    let Some(context) = device() else { return };
    let [least, most] = context.device_info().subgroup_sizes;
    let with = |size| Context::new(&ContextOptions { subgroup_size: Some(size), ..ContextOptions::default() });
    for size in [least, most] {
        assert_eq!(with(size).unwrap().device_info().subgroup_size, size);
    }
    for size in [2 * most, most - 1] {
        let error = with(size).err().unwrap();
        assert!(matches!(error, VulkanError::SubgroupSize { wanted, .. } if wanted == size), "{error:?}");
    }
}

/// Says what `list_gpus` says, for the next test, which runs it without drivers.
#[test]
#[ignore = "run by the next test"]
fn what_list_gpus_says() {
    match list_gpus() {
        Ok(gpus) => println!("{} GPUs", gpus.len()),
        Err(error) => println!("{error:?}: {error}"),
    }
}

#[test]
fn a_machine_without_drivers_names_the_package_to_install() {
    if matches!(list_gpus(), Err(VulkanError::NoLoader { .. })) {
        println!("skipped: no Vulkan loader");
        return;
    }
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "--ignored", "--nocapture", "vulkan::tests::machine::what_list_gpus_says"])
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("NoDriver: ") && text.contains("mesa-vulkan-drivers"), "{text}");
}

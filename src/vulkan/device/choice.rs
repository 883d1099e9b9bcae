//! Which GPU to take: what the user asked for, against the GPUs that there are. In: a text or a choice, and facts of GPUs. Out: one of them,
//! or an error that lists them.

use super::gpu::GpuInfo;
use crate::vulkan::error::{Result, VulkanError};

/// Fewest hex digits that are read as the beginning of a UUID; fewer decimal digits are a number.
const LEAST_UUID_DIGITS: usize = 8;

/// Hex digits of a whole UUID.
const UUID_DIGITS: usize = 32;

/// Which GPU to use.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum GpuChoice {
    /// The best usable one: discrete before integrated before virtual before CPU.
    #[default]
    Auto,
    /// The one with this [`GpuInfo::index`].
    Index(usize),
    /// The usable one of this name, or the only usable one whose name contains this text, in any case.
    Name(String),
    /// The only usable one whose [`GpuInfo::uuid`] begins with these hex digits, in lower case and without dashes.
    Uuid(String),
}

impl GpuChoice {
    /// What a user's text asks for: up to seven decimal digits are a number, from 8 to 32 hex digits, with dashes or without and with or
    /// without the `GPU-` of NVIDIA's tools, are a UUID or its beginning, and anything else is part of a name.
    pub fn parse(text: &str) -> GpuChoice {
        let text = text.trim();
        if let Some(index) = text.parse().ok().filter(|_| text.len() < LEAST_UUID_DIGITS) {
            return GpuChoice::Index(index);
        }
        let lower = text.to_lowercase();
        let digits = lower.strip_prefix("gpu-").unwrap_or(&lower).replace('-', "");
        let fits = (LEAST_UUID_DIGITS..=UUID_DIGITS).contains(&digits.len());
        match fits && digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            true => GpuChoice::Uuid(digits),
            false => GpuChoice::Name(text.to_owned()),
        }
    }

    fn fits(&self, gpu: &GpuInfo) -> bool {
        match self {
            GpuChoice::Auto => true,
            GpuChoice::Index(index) => gpu.index == *index,
            GpuChoice::Name(name) => gpu.name.to_lowercase().contains(&name.to_lowercase()),
            GpuChoice::Uuid(digits) => gpu.uuid.replace('-', "").starts_with(digits),
        }
    }

    fn wanted(&self) -> String {
        match self {
            GpuChoice::Auto => "any".to_owned(),
            GpuChoice::Index(index) => index.to_string(),
            GpuChoice::Name(text) | GpuChoice::Uuid(text) => text.clone(),
        }
    }
}

/// The [`GpuInfo::index`] of the one usable GPU that a choice means.
///
/// # Errors
/// No usable GPU, none that fits, or several that fit.
pub(super) fn pick(gpus: &[GpuInfo], choice: &GpuChoice) -> Result<usize> {
    let usable = || gpus.iter().filter(|gpu| gpu.unusable.is_empty());
    if *choice == GpuChoice::Auto {
        let best = usable().min_by_key(|gpu| (gpu.kind, gpu.index));
        return best.map(|gpu| gpu.index).ok_or_else(|| VulkanError::NoUsableDevice { reasons: lines(gpus.iter()) });
    }
    let fitting: Vec<&GpuInfo> = usable().filter(|gpu| choice.fits(gpu)).collect();
    // "RTX 4070" is a GPU's name, though "RTX 4070 Ti" contains it, too.
    let whole = |gpu: &&&GpuInfo| matches!(choice, GpuChoice::Name(name) if gpu.name.eq_ignore_ascii_case(name));
    let of_that_name: Vec<&GpuInfo> = fitting.iter().filter(whole).copied().collect();
    match (of_that_name.as_slice(), fitting.as_slice()) {
        ([only], _) | (_, [only]) => Ok(only.index),
        (_, []) => Err(VulkanError::NoSuchGpu { wanted: choice.wanted(), available: lines(gpus.iter()) }),
        _ => Err(VulkanError::SeveralGpus { wanted: choice.wanted(), fitting: lines(fitting.into_iter()) }),
    }
}

/// One line a GPU: number, name, kind, whether it can be used, and its UUID.
fn lines<'a>(gpus: impl Iterator<Item = &'a GpuInfo>) -> Vec<String> {
    let line = |gpu: &GpuInfo| {
        let verdict = match gpu.unusable.is_empty() {
            true => "usable".to_owned(),
            false => format!("lacks {}", gpu.unusable.join(", ")),
        };
        format!("  {}: {} ({}), UUID {}: {verdict}", gpu.index, gpu.name, gpu.kind.as_str(), gpu.uuid)
    };
    gpus.map(line).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failure fails the test")]
mod tests {
    use super::super::gpu::GpuKind;
    use super::*;

    fn gpu(index: usize, name: &str, kind: GpuKind, uuid: &str) -> GpuInfo {
        GpuInfo {
            index,
            name: name.to_owned(),
            kind,
            uuid: uuid.to_owned(),
            driver: String::new(),
            driver_info: String::new(),
            api_version: "1.3.0".to_owned(),
            vendor_id: 0,
            device_id: 0,
            subgroup_size: 32,
            subgroup_sizes: [32; 2],
            unusable: Vec::new(),
        }
    }

    /// A software renderer, twins, one whose name is longer than the twins', and one that lacks something.
    fn machine() -> Vec<GpuInfo> {
        let mut old = gpu(4, "Old Radeon", GpuKind::Discrete, "eeeeeeee-0000-0000-0000-000000000000");
        old.unusable.push("maintenance4".to_owned());
        vec![
            gpu(0, "llvmpipe", GpuKind::Cpu, "aaaaaaaa-0000-0000-0000-000000000000"),
            gpu(1, "GeForce 4070", GpuKind::Discrete, "12345678-1111-0000-0000-000000000000"),
            gpu(2, "GeForce 4070", GpuKind::Discrete, "12345678-2222-0000-0000-000000000000"),
            gpu(3, "GeForce 4070 Ti", GpuKind::Discrete, "dddddddd-0000-0000-0000-00000000abcd"),
            old,
        ]
    }

    fn picked(text: &str) -> Result<usize> {
        pick(&machine(), &GpuChoice::parse(text))
    }

    #[test]
    fn a_text_is_a_number_a_uuid_or_part_of_a_name() {
        assert_eq!(GpuChoice::parse("2"), GpuChoice::Index(2));
        assert_eq!(GpuChoice::parse("1234567"), GpuChoice::Index(1_234_567));
        assert_eq!(GpuChoice::parse("12345678"), GpuChoice::Uuid("12345678".to_owned()));
        assert_eq!(GpuChoice::parse("GPU-ABCDEF01-2345"), GpuChoice::Uuid("abcdef012345".to_owned()));
        assert_eq!(GpuChoice::parse("abcdef0"), GpuChoice::Name("abcdef0".to_owned()));
        assert_eq!(GpuChoice::parse("Radeon"), GpuChoice::Name("Radeon".to_owned()));
        let too_long = "0".repeat(33);
        assert_eq!(GpuChoice::parse(&too_long), GpuChoice::Name(too_long.clone()));
    }

    #[test]
    fn twins_are_told_apart_by_number_and_by_uuid() {
        assert_eq!(picked("2").unwrap(), 2);
        assert_eq!(picked("12345678-1111").unwrap(), 1);
        assert_eq!(picked("123456782222").unwrap(), 2);
        assert_eq!(picked("GPU-12345678-2222-0000-0000-000000000000").unwrap(), 2);
    }

    #[test]
    fn what_fits_several_is_an_error_that_lists_those() {
        for text in ["geforce", "GeForce 4070", "12345678"] {
            let error = picked(text).unwrap_err();
            assert!(matches!(error, VulkanError::SeveralGpus { .. }), "{error:?}");
            let said = error.to_string();
            for part in ["1: GeForce 4070 (discrete), UUID 12345678-1111", "2: GeForce 4070", "number or UUID"] {
                assert!(said.contains(part), "{part}: {said}");
            }
            assert!(!said.contains("llvmpipe"), "{said}");
        }
    }

    #[test]
    fn a_whole_name_is_not_mistaken_for_part_of_another() {
        assert_eq!(picked("geforce 4070 ti").unwrap(), 3);
        let one_of_each: Vec<GpuInfo> = machine().into_iter().filter(|gpu| gpu.index != 2).collect();
        assert_eq!(pick(&one_of_each, &GpuChoice::parse("geforce 4070")).unwrap(), 1);
    }

    #[test]
    fn the_best_usable_gpu_is_taken_unless_told_otherwise() {
        assert_eq!(pick(&machine(), &GpuChoice::Auto).unwrap(), 1);
        let error = picked("radeon").unwrap_err();
        assert!(matches!(error, VulkanError::NoSuchGpu { .. }) && error.to_string().contains("maintenance4"), "{error}");
        let error = pick(&machine()[4..], &GpuChoice::Auto).unwrap_err();
        assert!(matches!(error, VulkanError::NoUsableDevice { .. }), "{error:?}");
    }
}

//! Reflection of the compiled test shaders.

use crate::shaders::test::{BALLOT_COMP, SQUARE_COMP, TRIANGLE_FRAG, TRIANGLE_VERT};
use crate::vulkan::{vk, BindingKind, Reflection, Shader};

fn bindings(reflection: &Reflection) -> Vec<(&str, u32, BindingKind)> {
    reflection.bindings.iter().map(|b| (b.name.as_str(), b.number, b.kind)).collect()
}

#[test]
fn bindings_and_push_constants_are_read_from_spirv() {
    let ballot = Reflection::new(&BALLOT_COMP, &[]).unwrap();
    assert_eq!(ballot.stage, vk::ShaderStageFlags::COMPUTE);
    assert_eq!(bindings(&ballot), [("counts", 0, BindingKind::Storage)]);
    assert_eq!(ballot.push_constant_bytes, 12);
    let square = Reflection::new(&SQUARE_COMP, &[]).unwrap();
    let expected = [("source", 0, BindingKind::Sampled), ("target", 1, BindingKind::StorageImage)];
    assert_eq!(bindings(&square), expected);
    assert_eq!(square.push_constant_bytes, 0);
    let vertex = Reflection::new(&TRIANGLE_VERT, &[]).unwrap();
    assert_eq!(bindings(&vertex), [("vertices", 0, BindingKind::Storage)]);
    assert_eq!(vertex.workgroup_size, [0; 3]);
    let fragment = Reflection::new(&TRIANGLE_FRAG, &[]).unwrap();
    assert_eq!(bindings(&fragment), [("pages", 1, BindingKind::Sampled)]);
    assert_eq!(fragment.push_constant_bytes, 20);
}

#[test]
fn workgroup_sizes_follow_specialization() {
    let size = |constants: &[(u32, u32)]| Reflection::new(&BALLOT_COMP, constants).unwrap().workgroup_size;
    assert_eq!(size(&[]), [1, 1, 1]);
    assert_eq!(size(&[(0, 256)]), [256, 1, 1]);
    assert_eq!(size(&[(7, 256)]), [1, 1, 1], "another constant changes nothing");
    assert_eq!(Reflection::new(&SQUARE_COMP, &[(0, 9)]).unwrap().workgroup_size, [8, 8, 1]);
}

#[test]
fn damaged_spirv_is_an_error() {
    let words = BALLOT_COMP.words;
    let cut = &words[..words.len() - 1];
    let mut zero = words.to_vec();
    zero[5] = 0;
    for words in [&[][..], &words[1..], cut, &zero, &words[..5]] {
        assert!(Reflection::new(&Shader { name: "damaged", words }, &[]).is_err());
    }
}

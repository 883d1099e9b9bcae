//! The part of a SPIR-V module that reflection needs: names, decorations, types and constants, one pass over the words.

use std::collections::HashMap;

/// First word of a SPIR-V module.
const MAGIC: u32 = 0x0723_0203;
/// Words before the first instruction.
const HEADER_WORDS: usize = 5;

/// Opcode of the last instruction of every shader.
const FUNCTION_END: u32 = 56;

/// Numbers of SPIR-V decorations.
pub(crate) mod decoration {
    pub(crate) const SPEC_ID: u32 = 1;
    pub(crate) const BLOCK: u32 = 2;
    pub(crate) const BUFFER_BLOCK: u32 = 3;
    pub(crate) const ARRAY_STRIDE: u32 = 6;
    pub(crate) const MATRIX_STRIDE: u32 = 7;
    pub(crate) const BUILT_IN: u32 = 11;
    pub(crate) const BINDING: u32 = 33;
    pub(crate) const DESCRIPTOR_SET: u32 = 34;
    pub(crate) const OFFSET: u32 = 35;
}

/// A SPIR-V type, as far as bindings and push constants use them.
#[derive(Debug, Clone)]
pub(crate) enum Type {
    /// Integer or float of so many bytes.
    Scalar(u32),
    /// Vector of component type and count.
    Vector(u32, u32),
    /// Matrix of column type and count.
    Matrix(u32, u32),
    /// Image; true for storage images.
    Image(bool),
    Sampler,
    SampledImage,
    /// Array of element type and the id of the length.
    Array(u32, u32),
    RuntimeArray,
    Struct(Vec<u32>),
    /// Pointer to a type.
    Pointer(u32),
}

/// A module-scope variable.
pub(crate) struct Variable {
    pub(crate) id: u32,
    pub(crate) type_id: u32,
    pub(crate) class: u32,
}

/// What one pass over a module collects.
#[derive(Default)]
pub(crate) struct Module {
    pub(crate) names: HashMap<u32, String>,
    pub(crate) types: HashMap<u32, Type>,
    pub(crate) constants: HashMap<u32, u32>,
    /// Constituents of composite constants.
    pub(crate) composites: HashMap<u32, Vec<u32>>,
    pub(crate) variables: Vec<Variable>,
    /// Execution model and name of the first entry point.
    pub(crate) entry: Option<(u32, String)>,
    pub(crate) local_size: Option<[u32; 3]>,
    /// Ids of constants.
    pub(crate) local_size_id: Option<[u32; 3]>,
    decorations: HashMap<(u32, u32), u32>,
    member_decorations: HashMap<(u32, u32, u32), u32>,
}

impl Module {
    /// Parses SPIR-V; the error says what is wrong with it.
    pub(crate) fn parse(words: &[u32]) -> Result<Self, String> {
        if words.len() < HEADER_WORDS || words[0] != MAGIC {
            return Err("not SPIR-V".to_owned());
        }
        let mut module = Self::default();
        let mut rest = &words[HEADER_WORDS..];
        let mut last = 0;
        while let Some(&first) = rest.first() {
            let (length, opcode) = ((first >> 16) as usize, first & 0xffff);
            if length == 0 || length > rest.len() {
                return Err("damaged SPIR-V: an instruction is cut off".to_owned());
            }
            module.instruction(opcode, &rest[1..length]);
            rest = &rest[length..];
            last = opcode;
        }
        if last != FUNCTION_END {
            return Err("damaged SPIR-V: its end is missing".to_owned());
        }
        Ok(module)
    }

    /// Decoration of an id.
    pub(crate) fn decoration(&self, id: u32, decoration: u32) -> Option<u32> {
        self.decorations.get(&(id, decoration)).copied()
    }

    /// Decoration of a struct member.
    pub(crate) fn member(&self, id: u32, member: u32, decoration: u32) -> Option<u32> {
        self.member_decorations.get(&(id, member, decoration)).copied()
    }

    /// Size in bytes of a type in an explicit layout, up to the end of its last member. 0 if it has none.
    pub(crate) fn size(&self, id: u32) -> u32 {
        match self.types.get(&id) {
            Some(Type::Scalar(bytes)) => *bytes,
            Some(Type::Vector(of, count) | Type::Matrix(of, count)) => self.size(*of) * count,
            Some(Type::Array(of, length)) => {
                let count = self.constants.get(length).copied().unwrap_or(0);
                let stride = self.decoration(id, decoration::ARRAY_STRIDE);
                stride.unwrap_or_else(|| self.size(*of)) * count
            }
            Some(Type::Struct(members)) => {
                let ends = (0u32..).zip(members).map(|(i, of)| self.member_end(id, i, *of));
                ends.max().unwrap_or(0)
            }
            // Addresses.
            Some(Type::Pointer(_)) => 8,
            _ => 0,
        }
    }

    fn member_end(&self, id: u32, index: u32, of: u32) -> u32 {
        let start = self.member(id, index, decoration::OFFSET).unwrap_or(0);
        let size = match (self.types.get(&of), self.member(id, index, decoration::MATRIX_STRIDE)) {
            (Some(Type::Matrix(_, columns)), Some(stride)) => columns * stride,
            _ => self.size(of),
        };
        start + size
    }

    // Opcodes from the SPIR-V specification, section 3.52. Instructions that are too short are left out.
    fn instruction(&mut self, opcode: u32, words: &[u32]) {
        match (opcode, words) {
            (5, [id, name @ ..]) => {
                self.names.insert(*id, text(name));
            }
            (15, [model, _, name @ ..]) if self.entry.is_none() => {
                self.entry = Some((*model, text(name)));
            }
            (16, [_, 17, x, y, z]) => self.local_size = Some([*x, *y, *z]),
            (331, [_, 38, x, y, z]) => self.local_size_id = Some([*x, *y, *z]),
            (43 | 50, [_, id, value, ..]) => {
                self.constants.insert(*id, *value);
            }
            (44 | 51, [_, id, parts @ ..]) => {
                self.composites.insert(*id, parts.to_vec());
            }
            (59, [type_id, id, class, ..]) => {
                self.variables.push(Variable { id: *id, type_id: *type_id, class: *class });
            }
            (71, [id, decoration, value @ ..]) => {
                let value = value.first().copied().unwrap_or(0);
                self.decorations.insert((*id, *decoration), value);
            }
            (72, [id, member, decoration, value @ ..]) => {
                let value = value.first().copied().unwrap_or(0);
                self.member_decorations.insert((*id, *member, *decoration), value);
            }
            _ => self.type_instruction(opcode, words),
        }
    }

    fn type_instruction(&mut self, opcode: u32, words: &[u32]) {
        let (id, kind) = match (opcode, words) {
            (21 | 22, [id, bits, ..]) => (id, Type::Scalar(bits / 8)),
            (23, [id, of, count]) => (id, Type::Vector(*of, *count)),
            (24, [id, of, count]) => (id, Type::Matrix(*of, *count)),
            // Operand "sampled": 2 is a storage image.
            (25, [id, _, _, _, _, _, sampled, ..]) => (id, Type::Image(*sampled == 2)),
            (26, [id]) => (id, Type::Sampler),
            (27, [id, _]) => (id, Type::SampledImage),
            (28, [id, of, length]) => (id, Type::Array(*of, *length)),
            (29, [id, _]) => (id, Type::RuntimeArray),
            (30, [id, members @ ..]) => (id, Type::Struct(members.to_vec())),
            (32, [id, _, of]) => (id, Type::Pointer(*of)),
            _ => return,
        };
        self.types.insert(*id, kind);
    }
}

/// A literal string: bytes in little-endian words up to a null byte.
fn text(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes());
    let bytes: Vec<u8> = bytes.take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

//! What the fuzzer calls, one function a target. A test of the planet package calls the same functions with every seed.
//!
//! In: any bytes. Out: nothing; a panic, a leak or too much memory is the finding.

use terrane_heightfield::import;
use terrane_heightfield::import::photo;
use terrane_heightfield::import::{Encoding, NoData, Options, RawType, Window, MOST_SAMPLES};
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::Face;
use terrane_planet::mesh::progressive::MeshPrefix;
use terrane_planet::store::record::{seal, RecordWriter};
use terrane_planet::store::{geometry, imagery, surroundings, RecordError};

/// Every reader of heightfields keeps its word about what it returns.
fn heightfield(bytes: &[u8], name: &str) {
    heightfield_with(bytes, name, &Options::default());
}

fn heightfield_with(bytes: &[u8], name: &str, options: &Options) {
    let Ok(image) = import::read_with(bytes, name, options) else { return };
    let heights = image.field.heights();
    assert!(heights.len() <= MOST_SAMPLES && heights.iter().all(|h| !h.is_infinite()));
    assert_eq!(heights.iter().filter(|h| h.is_nan()).count(), image.no_data);
    assert!(image.range[0] <= image.range[1] && image.no_data < heights.len());
    assert!(image.spacing_m.is_none_or(|spacing| spacing.iter().all(|s| s.is_finite())));
    assert!(image.spacing_m.is_none() || image.unplaced.is_none());
    if heights.len() < 1 << 16 {
        let mut field = image.field;
        assert_eq!(field.fill_gaps(), image.no_data);
        assert!(field.heights().iter().all(|h| h.is_finite()));
    }
}

pub fn png(bytes: &[u8]) {
    heightfield(&with_magic(&[0x89, b'P', b'N', b'G'], bytes), "a.png");
}

pub fn tiff(bytes: &[u8]) {
    heightfield(bytes, "a.tif");
}

pub fn raw(bytes: &[u8]) {
    heightfield(bytes, "a.raw");
}

/// Short inputs stand for a whole tile, repeated: the fuzzer would never write three megabytes.
pub fn hgt(bytes: &[u8]) {
    let name = String::from_utf8_lossy(&bytes[..bytes.len().min(11)]) + ".hgt";
    heightfield(bytes, &name);
    if bytes.len() > 1 {
        heightfield(&bytes.iter().copied().cycle().take(2 * 1201 * 1201).collect::<Vec<u8>>(), &name);
    }
}

/// Esri ASCII grids.
pub fn grid(bytes: &[u8]) {
    heightfield(&[b"ncols ", bytes].concat(), "a.asc");
}

/// Compressed files, whole and as what the bytes would be inside gzip's header.
pub fn archive(bytes: &[u8]) {
    heightfield(&with_magic(b"PK\x03\x04", bytes), "a.zip");
    heightfield(&with_magic(&[0x1f, 0x8b, 8, 0], bytes), "N36W085.hgt.gz");
}

/// What a user may say about any file: the first bytes choose, the rest is the file.
pub fn options(bytes: &[u8]) {
    let Some((choice, file)) = bytes.split_first_chunk::<6>() else { return };
    let types: Vec<&str> = RawType::NAMES.split([',', ' ']).filter(|name| !name.is_empty()).collect();
    let small = |byte: u8| usize::from(byte % 16);
    let options = Options {
        no_data: [None, Some(NoData::Value(f64::from(choice[1]))), Some(NoData::Declared)][usize::from(choice[0] % 3)],
        encoding: [None, Some(Encoding::Terrarium), Some(Encoding::Mapbox)][usize::from(choice[1] % 3)],
        raw_size: (choice[0] & 64 > 0).then(|| [small(choice[2]), small(choice[3])]),
        raw_type: (choice[0] & 128 > 0).then(|| RawType::named(types[usize::from(choice[4]) % types.len()])).flatten(),
        window: (choice[0] & 32 > 0).then(|| {
            let [column, row, columns, rows] = [choice[2], choice[3], choice[4], choice[5]].map(small);
            Window { column, row, columns, rows }
        }),
        overview: (choice[0] & 16 > 0).then(|| small(choice[5])),
        ..Options::default()
    };
    heightfield_with(file, "a", &options);
}

/// Coordinate systems as users name them: of a grid far from the origin, and of one near it.
pub fn systems(bytes: &[u8]) {
    let options = Options { crs: Some(String::from_utf8_lossy(bytes).into_owned()), ..Options::default() };
    for place in ["xllcorner 500000 yllcorner 5200000 cellsize 10", "xllcorner 3 yllcorner 40 cellsize 0.01"] {
        heightfield_with(format!("ncols 2 nrows 2 {place} 1 2 3 4").as_bytes(), "a.asc", &options);
    }
}

/// Every reader of pictures keeps its word about what it returns.
pub fn photo(bytes: &[u8]) {
    for magic in [&[][..], &[0xff, 0xd8, 0xff], &[0x89, b'P', b'N', b'G']] {
        let Ok(photo) = photo::read(&with_magic(magic, bytes), "a.jpg") else { continue };
        let [columns, rows] = photo.size();
        assert!(columns >= 2 && rows >= 2 && columns * rows <= MOST_SAMPLES && photo.pixels.len() == columns * rows);
    }
}

/// The bytes behind a format's first ones, which the reader needs to know it.
fn with_magic(magic: &[u8], bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes.iter_mut().zip(magic).for_each(|(byte, magic)| *byte = *magic);
    bytes
}

/// The patch of all records here, and the grid of those of textures and surroundings.
pub fn patch() -> Option<(PatchId, u32)> {
    Some((PatchId::new(Face::ALL[2], 3, 1, 6)?, 8))
}

/// The grid of geometry records: the coarsest with several chunks.
pub const GEOMETRY_CELLS: u32 = 32;

/// Records to decode: the bytes with the lengths and the checksum that their header should state; and one whose streams
/// decompress, to the bytes and then zeros, so that the fuzzer need not learn to compress.
fn records(bytes: &[u8], magic: [u8; 4], streams: &[usize]) -> Vec<Vec<u8>> {
    let Some((id, cells)) = patch() else { return Vec::new() };
    let mut sealed = bytes.to_vec();
    let mut padded = bytes.to_vec();
    padded.resize(padded.len().max(streams.iter().sum()), 0);
    let mut record = RecordWriter::new(magic, id, cells);
    let mut rest = padded.as_slice();
    for &length in streams {
        let (stream, left) = rest.split_at(length);
        record.stream(stream);
        rest = left;
    }
    let mut all = vec![record.finish()];
    if seal(&mut sealed, magic, id, cells) {
        all.push(sealed);
    }
    all
}

/// What a reader accepts it writes again, and reads the same from that.
fn same_again<T: PartialEq>(
    decoded: T,
    encode: impl Fn(&T) -> Result<Vec<u8>, RecordError>,
    decode: impl Fn(&[u8]) -> Option<T>,
) {
    let bytes = encode(&decoded).expect("what was read can be written");
    assert!(decode(&bytes).is_some_and(|again| again == decoded), "what was written reads the same");
}

pub fn geometry(bytes: &[u8]) {
    let Some((id, _)) = patch() else { return };
    let decode = |record: &[u8]| geometry::decode(record, id, GEOMETRY_CELLS);
    let mut sealed = bytes.to_vec();
    let sealed = geometry::seal(&mut sealed, id, GEOMETRY_CELLS).then_some(sealed);
    for record in std::iter::once(geometry::of_raw(bytes, id, GEOMETRY_CELLS)).chain(sealed) {
        let whole = decode(&record);
        if let Ok(head) = geometry::Head::read(&record, id, GEOMETRY_CELLS) {
            for (k, chunk) in head.chunks.iter().enumerate() {
                let record = &record[..record.len().min(chunk.bytes.end)];
                let Ok(prefix) = geometry::decode_chunks(&head, record, id, GEOMETRY_CELLS, k + 1) else { continue };
                assert_eq!((prefix.mesh.vertices.len(), prefix.is_whole()), (chunk.end, k + 1 == head.chunks.len()));
                assert!(prefix.falls.iter().all(|&vertex| usize::from(vertex) < chunk.end));
                if let Ok(whole) = &whole {
                    let same = MeshPrefix::of(whole, chunk.end);
                    assert!(prefix.mesh == same.mesh && prefix.falls == same.falls, "a chunk reads the same alone");
                }
            }
        }
        if let Ok(mesh) = whole {
            same_again(mesh, geometry::encode, |record| decode(record).ok());
        }
    }
}

pub fn imagery(bytes: &[u8]) {
    let Some((id, cells)) = patch() else { return };
    let texels = terrane_planet::ground::texture::texture_side(cells).pow(2) as usize;
    let decode = |record: &[u8]| imagery::decode(record, id, cells);
    for record in records(bytes, imagery::MAGIC, &[texels; 6]) {
        if let Ok(texture) = decode(&record) {
            same_again(texture, |texture| imagery::encode(texture, id, cells), |record| decode(record).ok());
        }
    }
}

pub fn surroundings(bytes: &[u8]) {
    let Some((id, cells)) = patch() else { return };
    let samples = terrane_planet::ground::surroundings::surroundings_side(cells).pow(2);
    let decode = |record: &[u8]| surroundings::decode(record, id, cells);
    for record in records(bytes, surroundings::MAGIC, &[4 * samples]) {
        if let Ok(heights) = decode(&record) {
            same_again(heights, |heights| surroundings::encode(heights, id, cells), |record| decode(record).ok());
        }
    }
}

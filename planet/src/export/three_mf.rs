//! 3MF (3D Manufacturing Format, core specification 1.3): a ZIP archive of one XML model in metres, one object.

use super::{ExportError, Model, Up};
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use zip::write::SimpleFileOptions;
use zip::ZipWriter;

const TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
"#;

const RELATIONS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"#;

/// The bytes of a file.
///
/// # Errors
/// For more vertices than the format counts.
pub(super) fn encode(mesh: &Model, up: Up) -> Result<Vec<u8>, ExportError> {
    let (found, most) = (mesh.positions.len() as u64, i32::MAX as u64);
    if found > most {
        return Err(ExportError::TooLarge { what: "a number of vertices", found, format: "3MF", most });
    }
    pack(&model(mesh, up)).map_err(|error| ExportError::Archive { problem: error.to_string() })
}

fn pack(model: &str) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    // Entries without a time of day: the same mesh gives the same bytes.
    let options = SimpleFileOptions::default().last_modified_time(zip::DateTime::default());
    for (name, text) in [("[Content_Types].xml", TYPES), ("_rels/.rels", RELATIONS), ("3D/3dmodel.model", model)] {
        archive.start_file(name, options)?;
        archive.write_all(text.as_bytes())?;
    }
    Ok(archive.finish()?.into_inner())
}

/// The XML of the model. Writing to a string cannot fail.
fn model(mesh: &Model, up: Up) -> String {
    let mut xml = String::with_capacity(80 * mesh.positions.len() + 50 * mesh.triangles.len());
    let _ = write!(
        xml,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <model unit=\"meter\" xml:lang=\"en-US\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n\
         <metadata name=\"Application\">Terrane {}</metadata>\n<metadata name=\"Description\">{}; {}</metadata>\n\
         <resources><object id=\"1\" type=\"model\"><mesh><vertices>\n",
        env!("CARGO_PKG_VERSION"),
        mesh.axes(up),
        mesh.provenance.replace('&', "&amp;").replace('<', "&lt;")
    );
    for &position in &mesh.positions {
        let p = up.turn(position);
        let _ = writeln!(xml, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x, p.y, p.z);
    }
    xml.push_str("</vertices><triangles>\n");
    for [a, b, c] in mesh.triangles.iter() {
        let _ = writeln!(xml, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
    }
    xml.push_str("</triangles></mesh></object></resources>\n<build><item objectid=\"1\"/></build>\n</model>\n");
    xml
}

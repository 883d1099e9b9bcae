//! How meshes are written, as options that `mesh` and `simplify` share.

use super::packing::Meshoptimizer;
use super::pictures;
use anyhow::{bail, ensure, Context as _};
use std::path::{Path, PathBuf};
use terrane_planet::export::{check_map_side, Format, Model, Sidecar, Up};

/// The axis that points up.
#[derive(clap::ValueEnum, Clone, Copy)]
enum UpOption {
    /// Y up, and -Z for north (over a heightfield) or longitude 90 east (on a planet).
    Y,
    /// Z up, and +Y for north or longitude 90 east.
    Z,
}

/// How a mesh is written.
#[derive(clap::Args)]
pub(crate) struct ExportOptions {
    /// Axis that points up; on a planet, north [default: what programs expect of the format: y for OBJ and GLB, which has no other; z for
    /// PLY, STL and 3MF].
    #[arg(long, value_enum)]
    up: Option<UpOption>,
    /// Close the surface to a solid, with walls and a floor so many metres below its lowest vertex. STL and 3MF need it, unless the mesh
    /// is closed already. Faces are flat.
    #[arg(long, value_name = "METRES")]
    pub(crate) solid: Option<f64>,
    /// Write numbers of 16 bits to the GLB (KHR_mesh_quantization): half the size; positions move by up to half a 65,535th of the mesh's
    /// extent along each axis.
    #[arg(long)]
    quantize: bool,
    /// Pack the numbers of the GLB with meshoptimizer's codecs (EXT_meshopt_compression, which readers must then know); nothing is lost.
    #[arg(long)]
    compress: bool,
    /// Put maps of the ground into the GLB, so many texels along the longer side (a power of two from 64 to 8192), so that few triangles look like
    /// their ground: a normal map, and on a planet the albedo. The vertex normals then point straight up.
    #[arg(long, value_name = "TEXELS", conflicts_with = "solid")]
    pub(crate) maps: Option<u32>,
    /// Write where the mesh lies into two files beside it: x.prj, the coordinate system as WKT (or its proj string where no WKT is
    /// known; no file where no system is), and x.txt, its axes, unit and origin.
    #[arg(long)]
    pub(crate) sidecar: bool,
}

impl ExportOptions {
    /// The axis that points up in a file. Fails for what the format cannot hold, before any work.
    pub(crate) fn check(&self, format: Format) -> anyhow::Result<Up> {
        if let Some(below) = self.solid {
            ensure!(
                below > 0.0 && below.is_finite(),
                "--solid: found {below}, expected more than 0 metres below the lowest ground"
            );
        }
        ensure!(
            format == Format::Glb || !self.quantize,
            "--quantize: {} files cannot hold it; write a .glb or leave it out",
            format.name()
        );
        ensure!(
            format == Format::Glb || !self.compress,
            "--compress: {} files cannot hold it; write a .glb or leave it out",
            format.name()
        );
        if let Some(side) = self.maps {
            ensure!(format == Format::Glb, "--maps: {} files hold no maps; write a .glb or leave it out", format.name());
            check_map_side(side).context("--maps")?;
        }
        match self.up {
            Some(UpOption::Z) if format == Format::Glb => {
                anyhow::bail!("--up z: glTF is Y-up by its specification, and programs turn it themselves; leave it out")
            }
            Some(UpOption::Z) => Ok(Up::Z),
            Some(UpOption::Y) => Ok(Up::Y),
            None => Ok(format.usual_up()),
        }
    }

    /// The files beside a mesh that are asked for.
    pub(crate) fn sidecar(&self, model: &Model, format: Format) -> anyhow::Result<Option<Sidecar>> {
        let up = self.check(format)?;
        Ok(self.sidecar.then(|| model.sidecar(format, up)))
    }

    /// Fails if a file beside a mesh would take the place of one beside an input.
    pub(crate) fn check_sidecar(&self, mesh: &Path, inputs: &[PathBuf]) -> anyhow::Result<()> {
        let folder = |path: &Path| path.parent().map(|parent| Path::new(".").join(parent)).and_then(|p| p.canonicalize().ok());
        let is_beside = |input: &&PathBuf| input.file_stem() == mesh.file_stem() && folder(input) == folder(mesh);
        match inputs.iter().find(is_beside).filter(|_| self.sidecar) {
            Some(input) => bail!(
                "--sidecar: {} may belong to {}; give the mesh another name",
                mesh.with_extension("prj").display(),
                input.display()
            ),
            None => Ok(()),
        }
    }

    /// The bytes of a file.
    pub(crate) fn encode(&self, model: Model, format: Format) -> anyhow::Result<Vec<u8>> {
        let up = self.check(format)?;
        let model = if self.quantize { model.quantized() } else { model };
        if self.compress {
            return Ok(model.encode_packed(&Meshoptimizer)?);
        }
        Ok(model.encode(format, up)?)
    }

    /// The name of the axis that points up, for `--json`.
    pub(crate) fn up_name(&self, format: Format) -> anyhow::Result<&'static str> {
        Ok(match self.check(format)? {
            Up::Y => "y",
            Up::Z => "z",
        })
    }
}

/// Writes the files beside a mesh.
pub(crate) fn write_sidecar(mesh: &Path, sidecar: &Sidecar) -> anyhow::Result<()> {
    let write = |extension: &str, text: &str| {
        let path = mesh.with_extension(extension);
        pictures::write_whole(&path, text.as_bytes()).with_context(|| format!("cannot write {}", path.display()))
    };
    if let Some(projection) = &sidecar.projection {
        write("prj", projection)?;
    }
    write("txt", &sidecar.text)
}

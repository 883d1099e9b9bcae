//! Whether a file or a folder can be written, asked before the work that it is for.

use anyhow::{anyhow, bail, Context as _};
use std::path::Path;

/// What an option names.
#[derive(Clone, Copy)]
pub(crate) enum Output<'a> {
    /// A file in a folder that is there; with one of some extensions, in lower case and without dots, unless there are none.
    File(&'a [&'a str]),
    /// A folder, made with all above it if it is not there.
    Folder,
}

/// Fails if what an option names cannot be written: now, and not after minutes of work.
///
/// # Errors
/// With the option, the path, what is wrong with it, and what to do.
pub(crate) fn check_output(option: &str, path: &Path, output: Output) -> anyhow::Result<()> {
    match output {
        Output::File(extensions) => check_file(path, extensions),
        Output::Folder => check_folder(path),
    }
    .with_context(|| format!("{option}: cannot write {}", path.display()))
}

fn check_file(path: &Path, extensions: &[&str]) -> anyhow::Result<()> {
    if path.is_dir() {
        bail!("it is a folder; name a file in it");
    }
    path.file_name().context("it names no file")?;
    let found = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if !extensions.is_empty() && !extensions.contains(&found.as_str()) {
        bail!("its extension is '{found}', expected .{}", extensions.join(" or ."));
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        let found = if folder.exists() { "is no folder" } else { "does not exist" };
        bail!("its folder {} {found}; make it (mkdir -p) or choose another", folder.display());
    }
    check_writable(folder)
}

fn check_folder(folder: &Path) -> anyhow::Result<()> {
    if folder.exists() && !folder.is_dir() {
        bail!("it is a file; choose a folder");
    }
    std::fs::create_dir_all(folder).map_err(|error| anyhow!("the folder cannot be made ({error}); choose another"))?;
    check_writable(folder)
}

/// The one sure test of permissions, read-only disks and full ones: a file without a name, or one that goes at once.
fn check_writable(folder: &Path) -> anyhow::Result<()> {
    tempfile::tempfile_in(folder)
        .map(drop)
        .map_err(|error| anyhow!("no file can be made in {} ({error}); choose another folder", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_written_is_refused_with_a_way_out() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("file"), "").unwrap();
        std::fs::create_dir(at("a.png")).unwrap();
        let said = |name: &str, output| match check_output("--out", &at(name), output) {
            Ok(()) => "fine".to_owned(),
            Err(error) => format!("{error:#}"),
        };
        let png = Output::File(&["png", "exr"]);
        for (name, output, part) in [
            ("none/x.png", png, "none does not exist; make it"),
            ("file/x.png", png, "file is no folder; make it"),
            ("a.png", png, "it is a folder; name a file in it"),
            ("x.jpg", png, "its extension is 'jpg', expected .png or .exr"),
            ("x", png, "its extension is ''"),
            ("file", Output::Folder, "it is a file; choose a folder"),
            ("file/x", Output::Folder, "cannot be made"),
        ] {
            let found = said(name, output);
            assert!(found.contains(part) && found.starts_with("--out: cannot write /"), "{name}: {found}");
        }
        for (name, output) in
            [("x.PNG", png), ("file", Output::File(&[])), ("new/folder", Output::Folder), ("a.png", Output::Folder)]
        {
            assert_eq!(said(name, output), "fine", "{name}");
        }
        assert!(at("new/folder").is_dir() && !at("x.PNG").exists(), "a folder is made, a file is not");
        assert!(check_output("--out", Path::new("bare.png"), png).is_ok(), "a bare name is in this folder");
    }
}

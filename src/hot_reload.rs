//! Shaders that are compiled while the program runs, for who works on them.
//!
//! In: the folder of the shaders. Out: the SPIR-V of all of them, at first and after every change of a file there, or the compiler's
//! messages. A thread watches and compiles, so that frames go on meanwhile; `Renderer::reload` draws with what it found.

use crate::glsl::{compile, file_name, shader_files, Includes};
use crate::vulkan::Replacements;
use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher as _};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{channel, Receiver, Sender};
use std::sync::Arc;
use std::time::Duration;

/// How long files must stay as they are before they are read: editors write in several steps.
const QUIET: Duration = Duration::from_millis(100);

/// Follows a folder of shaders until it is dropped.
pub struct ShaderWatch {
    news: Receiver<Result<Replacements, String>>,
    // Dropped, it ends the thread.
    _watcher: RecommendedWatcher,
}

impl ShaderWatch {
    /// Begins to follow the shaders in `folder`, which is laid out as `shaders/` in Terrane's repository.
    ///
    /// # Errors
    /// Text for the user: no folder with shaders, or one that the system cannot watch.
    pub fn new(folder: &Path) -> Result<ShaderWatch, String> {
        if shader_files(folder)?.is_empty() {
            let place = folder.display();
            return Err(format!(
                "{place}: no shaders (*.comp, *.vert, *.frag) are there; name the folder `shaders` of the sources"
            ));
        }
        let (changed, changes) = channel();
        let describe = |error: notify::Error| format!("{}: cannot be watched: {error}", folder.display());
        let tell = move |event: notify::Result<Event>| {
            if event.is_ok_and(|event| !event.kind.is_access()) {
                // Who listens ends after this.
                let _ = changed.send(());
            }
        };
        let mut watcher = notify::recommended_watcher(tell).map_err(describe)?;
        watcher.watch(folder, RecursiveMode::Recursive).map_err(describe)?;
        let (found, news) = channel();
        let folder = folder.to_owned();
        let follow = move || follow(&folder, &changes, &found);
        std::thread::Builder::new().name("shaders".to_owned()).spawn(follow).map_err(|error| format!("no thread: {error}"))?;
        Ok(ShaderWatch { news, _watcher: watcher })
    }

    /// What was found since the last call: all shaders, or the messages of those that do not compile. The latest only.
    pub fn news(&self) -> Option<Result<Replacements, String>> {
        self.news.try_iter().last()
    }
}

/// Compiles at first and after every change, until nobody changes or nobody listens.
fn follow(folder: &Path, changes: &Receiver<()>, found: &Sender<Result<Replacements, String>>) {
    let mut compiler = Shelf::default();
    loop {
        if let Some(news) = compiler.update(folder) {
            if found.send(news).is_err() {
                return;
            }
        }
        if changes.recv().is_err() {
            return;
        }
        while changes.recv_timeout(QUIET).is_ok() {}
    }
}

/// The shaders of a folder as they were compiled last.
#[derive(Default)]
struct Shelf {
    compiled: BTreeMap<PathBuf, Compiled>,
}

/// A shader with the texts that it was compiled from.
struct Compiled {
    sources: BTreeMap<PathBuf, String>,
    words: Result<Arc<[u32]>, String>,
}

impl Shelf {
    /// Compiles what has changed. None if nothing has.
    fn update(&mut self, folder: &Path) -> Option<Result<Replacements, String>> {
        let files = match shader_files(folder) {
            Ok(files) => files,
            Err(problem) => return Some(Err(problem)),
        };
        let mut is_new = false;
        for path in &files {
            let sources = sources(path, folder);
            if self.compiled.get(path).is_none_or(|before| before.sources != sources) {
                let words = compile(path, folder).map(Arc::from);
                self.compiled.insert(path.clone(), Compiled { sources, words });
                is_new = true;
            }
        }
        self.compiled.retain(|path, _| files.contains(path));
        is_new.then(|| self.all())
    }

    /// All shaders, or the messages of those that do not compile: of a change of several, none is drawn with before all compile.
    fn all(&self) -> Result<Replacements, String> {
        let failed: BTreeSet<&str> =
            self.compiled.values().filter_map(|shader| shader.words.as_ref().err()).map(String::as_str).collect();
        if !failed.is_empty() {
            return Err(failed.into_iter().collect::<Vec<_>>().join("\n"));
        }
        let named = |(path, shader): (&PathBuf, &Compiled)| Some((file_name(path), shader.words.as_ref().ok()?.clone()));
        Ok(self.compiled.iter().filter_map(named).collect())
    }
}

/// The texts of a shader and of all that it includes, by path.
fn sources(path: &Path, root: &Path) -> BTreeMap<PathBuf, String> {
    let includes = Includes::new(path, root);
    let mut found = BTreeMap::new();
    let mut open = vec![(path.to_owned(), std::fs::read_to_string(path).unwrap_or_default())];
    while let Some((path, text)) = open.pop() {
        let names =
            text.lines().filter_map(|line| line.trim().strip_prefix("#include")?.trim().strip_prefix('"')?.split('"').next());
        open.extend(names.filter_map(|name| includes.find(name)).filter(|(path, _)| !found.contains_key(path)));
        found.insert(path, text);
    }
    found
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failure fails the test")]
mod tests {
    use super::*;
    use std::fs;
    use std::time::Instant;

    const SHADER: &str = "#version 460\n#include \"sum.glsl\"\nlayout(local_size_x = 64) in;\n\
        layout(binding = 0) buffer Sums { float sums[]; };\nvoid main() { sums[gl_GlobalInvocationID.x] = sum(1.0); }\n";
    const INCLUDED: &str = "float sum(float x) { return x + 1.0; }\n";

    /// A folder with a shader, what it includes, and another shader.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("shared")).unwrap();
        fs::write(folder.path().join("shared/sum.glsl"), INCLUDED).unwrap();
        fs::write(folder.path().join("sums.comp"), SHADER).unwrap();
        let other = SHADER.replace("#include \"sum.glsl\"\n", "").replace("sum(1.0)", "1.0");
        fs::write(folder.path().join("ones.comp"), other).unwrap();
        folder
    }

    #[test]
    fn what_is_changed_and_what_includes_it_is_compiled_again_and_nothing_else() {
        let folder = folder();
        let mut shelf = Shelf::default();
        let first = shelf.update(folder.path()).unwrap().unwrap();
        assert_eq!(first.keys().collect::<Vec<_>>(), ["ones.comp", "sums.comp"]);
        assert!(shelf.update(folder.path()).is_none());
        fs::write(folder.path().join("shared/sum.glsl"), INCLUDED.replace("1.0", "2.0")).unwrap();
        let second = shelf.update(folder.path()).unwrap().unwrap();
        assert!(second["sums.comp"] != first["sums.comp"]);
        assert!(Arc::ptr_eq(&second["ones.comp"], &first["ones.comp"]));
    }

    #[test]
    fn a_mistake_is_told_with_file_and_line_and_ends_with_it() {
        let folder = folder();
        let mut shelf = Shelf::default();
        shelf.update(folder.path()).unwrap().unwrap();
        fs::write(folder.path().join("shared/sum.glsl"), "\nfloat sum(float x) { return y; }\n").unwrap();
        let said = shelf.update(folder.path()).unwrap().unwrap_err();
        assert!(said.contains("sum.glsl:2:") && said.contains("'y'") && said.contains("sums.comp"), "{said}");
        fs::write(folder.path().join("shared/sum.glsl"), INCLUDED).unwrap();
        assert!(shelf.update(folder.path()).unwrap().is_ok());
    }

    #[test]
    fn a_watch_tells_of_the_shaders_at_first_and_of_each_change() {
        let folder = folder();
        let watch = ShaderWatch::new(folder.path()).unwrap();
        let wait = || {
            let begun = Instant::now();
            loop {
                if let Some(news) = watch.news() {
                    return news.unwrap();
                }
                assert!(begun.elapsed() < Duration::from_secs(30), "no news");
                std::thread::sleep(Duration::from_millis(10));
            }
        };
        let first = wait();
        fs::write(folder.path().join("sums.comp"), SHADER.replace("sum(1.0)", "sum(3.0)")).unwrap();
        assert!(wait()["sums.comp"] != first["sums.comp"]);
    }

    #[test]
    fn a_folder_without_shaders_is_refused_with_what_to_name() {
        let folder = tempfile::tempdir().unwrap();
        let said = ShaderWatch::new(folder.path()).err().unwrap();
        assert!(said.contains("no shaders") && said.contains("`shaders`"), "{said}");
    }
}

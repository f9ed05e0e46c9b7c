//! Files that somebody dropped on a page or that it fetched.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use gnomon_scene::builtin;
use gnomon_scene_files::{EnvironmentSource, ReadError, Resolver, plain};
use gnomon_studio::{Look, SceneFiles, SceneSource, StudioError};

type Map = HashMap<PathBuf, Arc<[u8]>>;

/// A scene's files and, beside them, those of its environment, which may be replaced.
#[derive(Clone, Debug, Default)]
pub struct Files {
    scene: Arc<Map>,
    around: Arc<Mutex<Map>>,
}

impl Files {
    /// The files of a scene, by their paths.
    pub fn new(files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Self {
        let scene = files.into_iter().map(|(path, bytes)| (plain(Path::new(&path)), bytes.into())).collect();
        Self { scene: Arc::new(scene), around: Arc::default() }
    }

    /// A built-in scene as a scene file, so that an environment can lie beside it.
    ///
    /// # Errors
    /// A name of nothing.
    pub fn of_builtin(name: &str) -> Result<(Self, SceneSource), StudioError> {
        if !builtin::NAMES.contains(&name) {
            let names = builtin::NAMES.join(", ");
            let name = gnomon_messages::quoted(name);
            return Err(StudioError::Request(format!(
                "there is no scene '{name}': the built-in ones are {names}"
            )));
        }
        let text = format!("[[model]]\nbuiltin = \"{name}\"\nground = true\n");
        let path = format!("{name}.toml");
        let files = Self::new([(path.clone(), text.into_bytes())]);
        let source = files.source(&path);
        Ok((files, source))
    }

    /// The scene file of that path.
    pub fn source(&self, path: &str) -> SceneSource {
        SceneSource::Files(SceneFiles::new(plain(Path::new(path)), self.clone()))
    }

    /// Puts a file of an environment beside the scene. Gives its path: another one where there is such a file already.
    pub fn put(&self, path: &str, bytes: Vec<u8>) -> PathBuf {
        let path = plain(Path::new(path));
        let mut around = locked(&self.around);
        let is_free = |path: &Path| !self.scene.contains_key(path) && !around.contains_key(path);
        let numbered = |number: u32| Path::new(&number.to_string()).join(&path);
        let free = match is_free(&path) {
            true => path,
            false => (2..).map(numbered).find(|path| is_free(path)).unwrap_or(path),
        };
        around.insert(free.clone(), bytes.into());
        free
    }

    /// Drops files of environments but those that a look names.
    pub fn keep_those_of(&self, look: &Look) {
        let environment = &look.environment;
        let named = [&environment.rig, &environment.background_map].into_iter().flatten().map(PathBuf::from);
        let mut kept: Vec<PathBuf> = named.map(|path| plain(&path)).collect();
        if let Some(EnvironmentSource::File(path)) = &look.map {
            kept.push(plain(path));
        }
        locked(&self.around).retain(|path, _| kept.contains(path));
    }

    /// Takes over the environment of another scene.
    pub fn take_environment_of(&self, other: &Self, look: &Look) {
        let map = if let Some(EnvironmentSource::File(path)) = &look.map { plain(path) } else { return };
        if let Some(bytes) = other.get(&map) {
            locked(&self.around).insert(map, bytes);
        }
    }

    fn get(&self, path: &Path) -> Option<Arc<[u8]>> {
        self.scene.get(path).cloned().or_else(|| locked(&self.around).get(path).cloned())
    }

    /// All of them, by their paths.
    pub fn all(&self) -> Vec<(String, Arc<[u8]>)> {
        let text = |path: &PathBuf| path.to_string_lossy().into_owned();
        let around = locked(&self.around);
        self.scene.iter().chain(around.iter()).map(|(path, bytes)| (text(path), Arc::clone(bytes))).collect()
    }
}

impl Resolver for Files {
    fn read(&self, path: &Path, most: usize) -> Result<Vec<u8>, ReadError> {
        let bytes = self.get(&plain(path)).ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))?;
        if bytes.len() <= most { Ok(bytes.to_vec()) } else { Err(ReadError::TooLong) }
    }
}

fn locked(map: &Mutex<Map>) -> MutexGuard<'_, Map> {
    map.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use gnomon_studio::environment_named;

    use super::*;

    fn read(files: &Files, path: &str) -> Option<Vec<u8>> {
        files.read(Path::new(path), 10).ok()
    }

    #[test]
    fn environments_come_and_go_beside_a_scene() {
        let files = Files::new([("a/b.obj".to_owned(), vec![1]), ("sky.hdr".to_owned(), vec![2])]);
        assert_eq!(read(&files, "a/../a/b.obj"), Some(vec![1]));
        // The scene's own file of that name stays.
        let path = files.put("sky.hdr", vec![3]);
        assert_eq!((path.to_str(), read(&files, "sky.hdr")), (Some("2/sky.hdr"), Some(vec![2])));
        let mut look = Look::default();
        look.set_environment(EnvironmentSource::File(path));
        let other = Files::of_builtin("column").unwrap().0;
        other.take_environment_of(&files, &look);
        assert_eq!(read(&other, "2/sky.hdr"), Some(vec![3]));
        files.put("dusk.hdr", vec![4]);
        files.keep_those_of(&look);
        assert_eq!((read(&files, "2/sky.hdr"), read(&files, "dusk.hdr")), (Some(vec![3]), None));
        look.set_environment(environment_named("sky"));
        files.keep_those_of(&look);
        assert_eq!(files.all().len(), 2);
        assert!(files.read(Path::new("a/b.obj"), 0).is_err() && Files::of_builtin("../x").is_err());
    }
}

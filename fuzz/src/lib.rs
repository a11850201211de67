//! Shared by the fuzz targets: a folder for the files of one scene, and the laws that every scene keeps.

use mlt_core::memory::Memory;
use mlt_core::transport::scene::{Scene, SceneDescription};
use mlt_scene::{LoadOptions, SceneError};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Memory that a scene may take, bytes.
const MEMORY: u64 = 256 << 20;

const OBJ: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl lamp\nf 1/1 2/2 3/3\n";
const MTL: &[u8] = b"newmtl lamp\nKd 1 1 1\nKe 1 1 1\nmap_Kd a.png\n";

/// A folder in memory, if the system has one. From here on all work is done by this thread: others take longer to wake than it takes.
pub fn folder() -> TempDir {
    // In a second thread of the fuzzer it is there already.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
    let shared = Path::new("/dev/shm");
    let folder = if shared.is_dir() { tempfile::tempdir_in(shared) } else { tempfile::tempdir() };
    folder.expect("a folder")
}

/// A folder with the scene `a.obj`: a lamp with the texture `a.png`, if that is there.
pub fn lamp() -> TempDir {
    let folder = folder();
    put(&folder, "a.obj", OBJ);
    put(&folder, "a.mtl", MTL);
    folder
}

/// Writes a file of a scene.
pub fn put(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("written");
    path
}

/// Opens a scene, checks it, and builds what is rendered.
pub fn open(path: &Path, options: &LoadOptions) -> Result<(), SceneError> {
    let memory = Memory::of(MEMORY);
    let loaded = mlt_scene::open_within(path, options, &memory)?;
    check(&loaded.description);
    let _ = Scene::new(loaded.description);
    Ok(())
}

/// The promises of a scene's description, whatever the file was.
fn check(scene: &SceneDescription) {
    for mesh in &scene.meshes {
        assert!((mesh.material as usize) < scene.materials.len());
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
    }
    assert!(scene.materials.iter().all(|m| m.emission.is_finite() && m.emission.min_element() >= 0.0));
}

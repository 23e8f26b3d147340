//! Files that a model file names: buffers and pictures.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;

use super::scene_file::refuse_special;
use crate::texture::decode;
use crate::{Encoding, Texture};

/// Reads what lies beside a model file.
pub(super) struct Resources {
    folder: PathBuf,
    textures: HashMap<(String, Encoding), Option<Arc<Texture>>>,
    /// What was wrong, each told once.
    pub(super) warnings: Vec<String>,
}

impl Resources {
    /// For a model file.
    pub(super) fn beside(path: &Path) -> Self {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self { folder, textures: HashMap::new(), warnings: Vec::new() }
    }

    /// The bytes behind a URI: base64 data, or a file beside the model.
    pub(super) fn read_uri(&self, uri: &str) -> Result<Vec<u8>, String> {
        match uri.strip_prefix("data:") {
            Some(data) => {
                let (_, payload) = data.split_once(";base64,").ok_or("a data URI is not base64")?;
                let engine = base64::engine::general_purpose::STANDARD;
                engine.decode(payload).map_err(|error| format!("a data URI: {error}"))
            }
            None => {
                let read = |path: PathBuf| refuse_special(&path).and_then(|()| std::fs::read(path));
                let plain = read(self.folder.join(uri.replace('\\', "/")));
                let decoded = || read(self.folder.join(percent_decoded(uri)));
                plain.or_else(|error| if uri.contains('%') { decoded() } else { Err(error) }).map_err(|e| e.to_string())
            }
        }
    }

    /// The texture of that name; `None`, with a warning, if it cannot be had. Its bytes come from `read`.
    pub(super) fn texture(
        &mut self,
        name: &str,
        encoding: Encoding,
        read: impl FnOnce(&Self) -> Result<Vec<u8>, String>,
    ) -> Option<Arc<Texture>> {
        let key = (name.to_owned(), encoding);
        if let Some(known) = self.textures.get(&key) {
            return known.clone();
        }
        let decoded = read(self).and_then(|bytes| decode(&bytes, encoding).map_err(|error| error.to_string()));
        let texture = match decoded {
            Ok(texture) => Some(Arc::new(texture)),
            Err(message) => {
                let warning = format!("texture {name:?} is left out: {message}; its surfaces take their plain colour");
                if !self.warnings.contains(&warning) {
                    self.warnings.push(warning);
                }
                None
            }
        };
        self.textures.insert(key, texture.clone());
        texture
    }
}

/// `%20` for a space and the like.
fn percent_decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let code = bytes.get(i + 1..i + 3).and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        match code {
            Some(code) if bytes[i] == b'%' => {
                decoded.push(code);
                i += 3;
            }
            _ => {
                decoded.push(bytes[i]);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&decoded).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_spaces_and_backslashes_are_found() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a b.bin"), [1, 2, 3]).unwrap();
        let resources = Resources::beside(&folder.path().join("model.gltf"));
        for uri in ["a%20b.bin", "a b.bin", ".\\a b.bin", "data:application/octet-stream;base64,AQID"] {
            assert_eq!(resources.read_uri(uri).unwrap(), [1, 2, 3], "{uri}");
        }
        assert!(resources.read_uri("none%2").is_err());
        assert!(resources.read_uri(".").is_err());
        assert_eq!(percent_decoded("%4a%zz%"), "J%zz%");
    }

    #[test]
    fn a_texture_is_read_once_and_missed_once() {
        let mut resources = Resources::beside(Path::new("none/model.gltf"));
        for _ in 0..3 {
            assert!(resources.texture("a.png", Encoding::Color, |own| own.read_uri("a.png")).is_none());
        }
        assert_eq!(resources.warnings.len(), 1);
        assert!(resources.warnings[0].contains("a.png"));
    }
}

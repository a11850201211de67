//! Scenes for `mlt-core`: glTF 2.0, OBJ and the built-in ones.

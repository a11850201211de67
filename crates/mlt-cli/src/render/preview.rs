//! The image so far, shown time and again.

use std::time::{Duration, Instant};

use mlt_core::engine::Film;

use super::tev::Tev;
use crate::{
    Failure,
    args::{render::RenderOptions, show::Preview},
    image::Image,
    output::{Frame, OutputFile, Picture},
    warn,
};

/// Time between two views.
const EVERY: Duration = Duration::from_secs(2);

/// Where the image so far is shown.
pub(super) struct Previews {
    screens: Vec<Screen>,
    exposure: f64,
    last: Instant,
}

/// The mark of an image that is not done.
fn under_way() -> Vec<(String, String)> {
    vec![("mlt.preview".to_owned(), "a render under way".to_owned())]
}

enum Screen {
    File(OutputFile),
    Tev(Tev),
}

impl Previews {
    /// Those that were asked for, of an image of this size.
    pub(super) fn open(options: &RenderOptions, size: [u32; 2]) -> Result<Self, Failure> {
        let name = format!("mlt: {}", options.scene.display());
        let screen = |preview: &Preview| match preview {
            Preview::File(file) => Ok(Screen::File(file.clone())),
            Preview::Tev(address) => Tev::open(address, &name, size).map(Screen::Tev),
        };
        let screens = options.show.previews.iter().map(screen).collect::<anyhow::Result<_>>();
        Ok(Self { screens: screens.map_err(Failure::Usage)?, exposure: options.exposure, last: Instant::now() })
    }

    /// Shows the film if it is time.
    pub(super) fn offer(&mut self, film: &Film<3>) {
        if self.last.elapsed() >= EVERY {
            self.show(film);
        }
    }

    /// Shows the film. A screen that fails is told of and dropped: the render goes on.
    pub(super) fn show(&mut self, film: &Film<3>) {
        if self.screens.is_empty() {
            return;
        }
        let [width, height] = film.size().map(|n| n as usize);
        let Ok(image) = Image::new(width, height, film.preview()) else { return };
        let frame = Frame::whole(&image);
        let (channels, attributes) = (Vec::new(), under_way());
        let picture = Picture { image, errors: None, channels, frame, attributes, exposure: self.exposure };
        self.screens.retain_mut(|screen| match screen.show(&picture) {
            Ok(()) => true,
            Err(error) => {
                warn(&format!("{error:#}; the render goes on without this preview"));
                false
            }
        });
        self.last = Instant::now();
    }
}

impl Screen {
    fn show(&mut self, picture: &Picture) -> anyhow::Result<()> {
        match self {
            Self::File(file) => file.write(|to| picture.write(file.format, to)),
            Self::Tev(tev) => tev.show(&picture.image),
        }
    }
}

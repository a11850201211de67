//! Features that camera rays find, for a render's files.

use mlt_core::transport::{
    render::{SurfaceFeatures, strongest_strata, surfaces},
    scene::View,
};

use crate::{
    args::{render::RenderOptions, show::Aov},
    denoise::Guides,
    output::Channel,
};

/// Features of an image.
#[derive(Clone, Debug, Default)]
pub(crate) struct Features {
    /// Further channels, as they were asked for.
    pub channels: Vec<Channel>,
    /// Input of a denoiser, if one is asked for.
    pub guides: Option<Guides>,
}

impl Features {
    /// Those that were asked for, on the current rayon pool.
    pub(super) fn find(options: &RenderOptions, view: View) -> Self {
        let asked = options.show.channels();
        let of_surfaces = asked.iter().any(|aov| !matches!(aov, Aov::Stratum | Aov::Stderr));
        let found = &if of_surfaces || options.show.denoise { surfaces(view) } else { Vec::new() };
        let channels = |&aov: &Aov| match aov {
            Aov::Stratum => {
                let strata = strongest_strata(view, options.transport.strata.lights);
                vec![single("stratum", strata.into_iter().map(|stratum| stratum.map_or(-1.0, |number| number as f32)))]
            }
            Aov::Stderr | Aov::All => Vec::new(),
            of_surfaces => channels(of_surfaces, found),
        };
        let guides = || Guides { albedo: each(found, |f| f.albedo), normal: each(found, |f| f.normal) };
        Self { channels: asked.iter().flat_map(channels).collect(), guides: options.show.denoise.then(guides) }
    }
}

/// The channels of a feature of surfaces.
fn channels(aov: Aov, found: &[SurfaceFeatures]) -> Vec<Channel> {
    let triples = |names, of| Channel::of_triples(names, &each(found, of)).to_vec();
    match aov {
        Aov::Albedo => triples(["albedo.R", "albedo.G", "albedo.B"], |feature| feature.albedo),
        Aov::Normal => triples(["N.X", "N.Y", "N.Z"], |feature| feature.normal),
        Aov::Position => triples(["P.X", "P.Y", "P.Z"], |feature| feature.position),
        Aov::Depth => vec![single("Z", found.iter().map(|feature| feature.depth))],
        Aov::Stratum | Aov::Stderr | Aov::All => Vec::new(),
    }
}

fn each(found: &[SurfaceFeatures], of: fn(&SurfaceFeatures) -> [f32; 3]) -> Vec<[f32; 3]> {
    found.iter().map(of).collect()
}

fn single(name: &str, values: impl Iterator<Item = f32>) -> Channel {
    Channel { name: name.into(), values: values.collect() }
}

//! The camera that options choose.

use anyhow::{Context, anyhow};
use glam::DVec3;
use mlt_core::transport::scene::{CameraPose, Lens, SceneDescription};

use crate::{Failure, args::render::RenderOptions, provenance::CameraUsed};

/// Opening angle where none is given, degrees.
const USUAL_FOV: f32 = 40.0;

/// The camera, and what the report says of it; `framed`: the camera for a scene that has none.
pub(super) fn pose(
    options: &RenderOptions,
    scene: &SceneDescription,
    framed: impl FnOnce() -> Option<CameraPose>,
) -> Result<(CameraPose, CameraUsed), Failure> {
    let (pose, origin) = chosen(options, scene, framed)?;
    let lens = lens(options, &pose).map_err(Failure::Usage)?;
    let pose = CameraPose { lens, ..pose };
    let used = CameraUsed::new(&pose, origin);
    Ok((pose, used))
}

fn chosen(
    options: &RenderOptions,
    scene: &SceneDescription,
    framed: impl FnOnce() -> Option<CameraPose>,
) -> Result<(CameraPose, &'static str), Failure> {
    let view = &options.view;
    if let (Some(from), Some(to)) = (view.camera_from, view.camera_to) {
        let [from, to] = [from, to].map(DVec3::from_array);
        return Ok((CameraPose::look_at(from, to, USUAL_FOV.to_radians()), "by --camera-from and --camera-to"));
    }
    if let Some(name) = &view.camera {
        let found = scene.cameras.iter().find(|camera| camera.name == *name);
        let missing = || {
            let names: Vec<_> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
            let there = mlt_scene::instead_of(name, &names);
            Failure::Usage(anyhow!("{}: there is no camera \"{name}\"; {there}", options.scene.display()))
        };
        return Ok((found.cloned().ok_or_else(missing)?, "by --camera"));
    }
    match &scene.cameras[..] {
        [only] => Ok((only.clone(), "the file's only one")),
        [first, ..] => Ok((first.clone(), "the file's first one")),
        [] => {
            let pose = framed().with_context(|| format!("{}: the scene has no triangle", options.scene.display()))?;
            Ok((pose, "around the whole scene, for want of another"))
        }
    }
}

/// The camera's lens with what the options change.
fn lens(options: &RenderOptions, pose: &CameraPose) -> anyhow::Result<Lens> {
    let view = &options.view;
    let Some(vertical_fov) = pose.lens.vertical_fov() else {
        let given =
            [("--fov", view.fov.is_some()), ("--aperture", view.aperture.is_some()), ("--focus", view.focus.is_some())];
        let refused = given.iter().find(|(_, given)| *given);
        return refused.map_or(Ok(pose.lens), |(option, _)| {
            Err(anyhow!("{option} has no meaning for an orthographic camera; leave it out, or choose another camera"))
        });
    };
    let vertical_fov = view.fov.map_or(vertical_fov, |degrees| degrees.to_radians() as f32);
    let (own_radius, own_focus) = match pose.lens {
        Lens::Thin { radius, focus, .. } => (Some(radius), Some(focus)),
        _ => (None, None),
    };
    let aspect = view
        .given_size()
        .map_or(pose.aspect_ratio.map_or(1.0, f64::from), |size| size.width as f64 / size.height as f64);
    let longer = 2.0 * libm::atan(aspect.max(1.0) * libm::tan(0.5 * f64::from(vertical_fov)));
    let radius = view.aperture.map(|aperture| aperture.radius(longer)).or(own_radius).filter(|&radius| radius > 0.0);
    let target = view.camera_from.zip(view.camera_to).map(|(from, to)| DVec3::from(from).distance(DVec3::from(to)));
    match (radius, view.focus.or(own_focus).or(target)) {
        (None, _) if view.focus.is_some() => {
            Err(anyhow!("--focus needs a lens: to a pinhole all is sharp; add --aperture, as in --aperture f/2.8"))
        }
        (None, _) => Ok(Lens::Pinhole { vertical_fov }),
        (Some(_), None) => {
            Err(anyhow!("--aperture needs the distance that is in focus; add --focus, as in --focus 2.5"))
        }
        (Some(radius), Some(focus)) => Ok(Lens::Thin { vertical_fov, radius, focus }),
    }
}

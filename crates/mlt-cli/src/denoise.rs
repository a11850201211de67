//! Open Image Denoise, where its library is found at run time.
//!
//! **What is unsafe** here is to load a library and to call its functions by the types that its C header has (version 2, in which
//! they do not change).
#![allow(unsafe_code, reason = "calls of a C library")]

use std::{
    ffi::{CStr, c_char, c_int, c_void},
    ptr,
};

use anyhow::{Context, anyhow, bail};
use libloading::{Library, Symbol};

use crate::image::Image;

/// Names of the library's files.
const NAMES: [&str; 4] =
    ["libOpenImageDenoise.so.2", "libOpenImageDenoise.2.dylib", "OpenImageDenoise.dll", "libOpenImageDenoise.so"];
/// Kind of device: processors, which read the caller's memory.
const PROCESSORS: c_int = 1;
/// Format of a pixel: three f32.
const FLOAT3: c_int = 3;

type Handle = *mut c_void;
type NewDevice = unsafe extern "C" fn(c_int) -> Handle;
type OfHandle = unsafe extern "C" fn(Handle);
type GetError = unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int;
type GetInt = unsafe extern "C" fn(Handle, *const c_char) -> c_int;
type NewFilter = unsafe extern "C" fn(Handle, *const c_char) -> Handle;
type SetBool = unsafe extern "C" fn(Handle, *const c_char, bool);
type SetImage = unsafe extern "C" fn(Handle, *const c_char, Handle, c_int, usize, usize, usize, usize, usize);

/// Features that guide the filter, for each pixel.
#[derive(Clone, Debug)]
pub struct Guides {
    /// Reflectance, 0…1.
    pub albedo: Vec<[f32; 3]>,
    /// Shading normals, of length 1 or less.
    pub normal: Vec<[f32; 3]>,
}

/// The library.
#[derive(Debug)]
pub struct Denoiser(Library);

impl Denoiser {
    /// Loads the library from where the system looks for libraries.
    pub fn load() -> anyhow::Result<Self> {
        // SAFETY: what runs when the library is loaded is its own set-up, which asks nothing of the caller.
        let found = NAMES.iter().find_map(|name| unsafe { Library::new(name) }.ok());
        found.map(Self).context(
            "--denoise: the library Open Image Denoise 2 (libOpenImageDenoise.so.2) is not found; install it from \
             openimagedenoise.org, name its folder in LD_LIBRARY_PATH, or render with --aov albedo,normal for another denoiser",
        )
    }

    /// The image with its noise filtered out, which is biased, and the library's version.
    pub fn denoise(&self, image: &Image, guides: &Guides) -> anyhow::Result<(Image, String)> {
        let pixels = image.width * image.height;
        if [&guides.albedo, &guides.normal, &image.rgb].iter().any(|values| values.len() != pixels) {
            bail!("the features do not have the image's size");
        }
        let mut denoised = image.clone();
        let device = self.device()?;
        // SAFETY: the handle is of a device that lives, and the name ends with 0.
        let version = unsafe { self.function::<GetInt>(c"oidnGetDeviceInt")?(device.handle, c"version".as_ptr()) };
        // SAFETY: as before.
        let handle = unsafe { self.function::<NewFilter>(c"oidnNewFilter")?(device.handle, c"RT".as_ptr()) };
        let filter = Owned { handle, release: self.function(c"oidnReleaseFilter")? };
        let size = [image.width, image.height];
        for (name, values) in [(c"color", &image.rgb), (c"albedo", &guides.albedo), (c"normal", &guides.normal)] {
            // The library only reads its inputs.
            self.set_image(&filter, name, values.as_ptr().cast_mut(), size)?;
        }
        self.set_image(&filter, c"output", denoised.rgb.as_mut_ptr(), size)?;
        // SAFETY: the filter lives; its images have width × height pixels of three f32, as checked above, and outlive it.
        unsafe {
            self.function::<SetBool>(c"oidnSetFilterBool")?(filter.handle, c"hdr".as_ptr(), true);
            self.function::<OfHandle>(c"oidnCommitFilter")?(filter.handle);
            self.function::<OfHandle>(c"oidnExecuteFilter")?(filter.handle);
        }
        self.check(&device)?;
        Ok((denoised, format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)))
    }

    fn device(&self) -> anyhow::Result<Owned<'_>> {
        let (new, commit) =
            (self.function::<NewDevice>(c"oidnNewDevice")?, self.function::<OfHandle>(c"oidnCommitDevice")?);
        // SAFETY: any number may name a kind; of one that is unknown the handle is null.
        let handle = unsafe { new(PROCESSORS) };
        if handle.is_null() {
            bail!("Open Image Denoise does not run on this machine's processors");
        }
        let device = Owned { handle, release: self.function(c"oidnReleaseDevice")? };
        // SAFETY: the handle is of a device that lives.
        unsafe { commit(device.handle) };
        self.check(&device)?;
        Ok(device)
    }

    fn set_image(
        &self,
        filter: &Owned,
        name: &CStr,
        pixels: *mut [f32; 3],
        [width, height]: [usize; 2],
    ) -> anyhow::Result<()> {
        let set = self.function::<SetImage>(c"oidnSetSharedFilterImage")?;
        // SAFETY: the filter lives, and reads or writes the pixels no sooner than it is executed.
        unsafe { set(filter.handle, name.as_ptr(), pixels.cast(), FLOAT3, width, height, 0, 0, 0) };
        Ok(())
    }

    /// The library's last error, if there is one.
    fn check(&self, device: &Owned) -> anyhow::Result<()> {
        let (get, mut message) = (self.function::<GetError>(c"oidnGetDeviceError")?, ptr::null());
        // SAFETY: the device lives, and the message is written to a pointer of its type.
        if unsafe { get(device.handle, &raw mut message) } == 0 {
            return Ok(());
        }
        let text = match message.is_null() {
            true => "no reason given".into(),
            // SAFETY: a message that is not null ends with 0 and lives until the next call.
            false => unsafe { CStr::from_ptr(message) }.to_string_lossy(),
        };
        Err(anyhow!("Open Image Denoise: {text}"))
    }

    /// A function of the library, which has to be of type `T`.
    fn function<T>(&self, name: &CStr) -> anyhow::Result<Symbol<'_, T>> {
        // SAFETY: all types above are those of the library's header.
        let found = unsafe { self.0.get(name.to_bytes_with_nul()) };
        found.with_context(|| format!("Open Image Denoise has no {}; version 2 is needed", name.to_string_lossy()))
    }
}

/// A device or a filter, released at the end.
struct Owned<'a> {
    handle: Handle,
    release: Symbol<'a, OfHandle>,
}

impl Drop for Owned<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle was made by the library and is released once.
        unsafe { (self.release)(self.handle) }
    }
}

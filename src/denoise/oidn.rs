//! Intel's Open Image Denoise 2 through its C interface, loaded while the program runs: one of the two files with unsafe code.
//!
//! The names, types and constants are those of `OpenImageDenoise/oidn.h` of version 2; no other major version is taken. Images are arrays of three
//! floats a pixel, row by row, which the library reads and writes in place and only while a filter is executed.
#![allow(unsafe_code)] // a foreign interface; each block says why it is sound

use libloading::Library as Shared;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;
use std::ptr;

type Handle = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`
const CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`
const FLOAT3: c_int = 3;
/// The version of the interface.
const MAJOR: c_int = 2;

/// Declares the functions of the library that are used, and how they are found in it.
macro_rules! functions {
    ($($field:ident = $name:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of the library.
        #[derive(Clone, Copy)]
        struct Functions {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// Finds them.
            fn find(library: &Shared) -> Result<Self, libloading::Error> {
                // SAFETY: these are the types that the header of version 2 gives to the functions of these names. Which version the library is
                // of is asked by `Library::open`, through functions that have the same types in version 1.
                unsafe { Ok(Self { $($field: *library.get::<unsafe extern "C" fn($($argument),*) $(-> $result)?>($name)?,)* }) }
            }
        }
    };
}

functions! {
    new_device = b"oidnNewDevice\0": fn(c_int) -> Handle;
    set_device_int = b"oidnSetDeviceInt\0": fn(Handle, *const c_char, c_int);
    set_device_bool = b"oidnSetDeviceBool\0": fn(Handle, *const c_char, bool);
    commit_device = b"oidnCommitDevice\0": fn(Handle);
    get_device_int = b"oidnGetDeviceInt\0": fn(Handle, *const c_char) -> c_int;
    get_device_error = b"oidnGetDeviceError\0": fn(Handle, *mut *const c_char) -> c_int;
    release_device = b"oidnReleaseDevice\0": fn(Handle);
    new_filter = b"oidnNewFilter\0": fn(Handle, *const c_char) -> Handle;
    set_shared_image = b"oidnSetSharedFilterImage\0": fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
    set_filter_bool = b"oidnSetFilterBool\0": fn(Handle, *const c_char, bool);
    set_filter_int = b"oidnSetFilterInt\0": fn(Handle, *const c_char, c_int);
    commit_filter = b"oidnCommitFilter\0": fn(Handle);
    execute_filter = b"oidnExecuteFilter\0": fn(Handle);
    release_filter = b"oidnReleaseFilter\0": fn(Handle);
}

/// The library, loaded; it stays so until the program ends, for it has threads of its own.
pub struct Library {
    functions: Functions,
    version: [c_int; 3],
}

impl Library {
    /// Loads the library from a file, or, if `path` is a name alone, from wherever the system's loader finds it.
    ///
    /// # Errors
    /// Why it cannot be used, in words.
    pub fn open(path: &Path) -> Result<Self, String> {
        // SAFETY: what a library does when it is loaded is its own affair; this one, of whatever version, prepares tables of its own.
        let library = unsafe { Shared::new(path) }.map_err(|e| e.to_string())?;
        let functions = Functions::find(&library).map_err(|_| "it is no Open Image Denoise of version 2".to_owned())?;
        // Never unloaded: the functions are valid for good.
        std::mem::forget(library);
        let mut found = Self { functions, version: [0; 3] };
        let version = Device::new(&found, 1)?.get(c"version");
        found.version = [version / 10_000, version / 100 % 100, version % 100];
        match found.version {
            [MAJOR, ..] => Ok(found),
            [major, minor, _] => Err(format!("it is of version {major}.{minor}, and version {MAJOR} is needed")),
        }
    }

    /// Its version, such as `2.5.1`.
    pub fn version(&self) -> String {
        self.version.map(|n| n.to_string()).join(".")
    }
}

/// The processor, as the library uses it.
pub struct Device<'l> {
    functions: &'l Functions,
    handle: Handle,
}

/// What a filter makes of its images.
#[derive(Clone, Copy, Debug, Default)]
pub struct FilterSettings {
    /// Whether the colours are light, of any brightness, and not between 0 and 1.
    pub hdr: bool,
    /// Whether albedo and normals are without noise.
    pub clean_guides: bool,
    /// Memory that it should not use more of, beyond the images (MB).
    pub most_megabytes: u16,
}

impl<'l> Device<'l> {
    /// The processor with so many threads; all that it has if that is 0.
    ///
    /// # Errors
    /// If the library finds nothing that runs on this processor.
    pub fn new(library: &'l Library, threads: u16) -> Result<Self, String> {
        let functions = &library.functions;
        // SAFETY: the function takes any number.
        let handle = unsafe { (functions.new_device)(CPU) };
        let device = Self { functions, handle };
        if handle.is_null() {
            return Err(device.error().unwrap_or_else(|| "it has nothing that runs on this processor".to_owned()));
        }
        // SAFETY: the device is one that was just made, the names are texts with an end.
        unsafe {
            (functions.set_device_int)(handle, c"numThreads".as_ptr(), c_int::from(threads));
            // Threads that are tied to cores disturb what else runs.
            (functions.set_device_bool)(handle, c"setAffinity".as_ptr(), false);
            (functions.commit_device)(handle);
        }
        device.error().map_or(Ok(device), Err)
    }

    fn get(&self, name: &CStr) -> c_int {
        // SAFETY: the device is one that was committed, the name a text with an end.
        unsafe { (self.functions.get_device_int)(self.handle, name.as_ptr()) }
    }

    /// What has gone wrong since it was last asked, in words.
    fn error(&self) -> Option<String> {
        let mut message = ptr::null();
        // SAFETY: the device is valid, or null, which asks for the errors of this thread; the message is written to a place of its type.
        let code = unsafe { (self.functions.get_device_error)(self.handle, &mut message) };
        if code == 0 {
            return None;
        }
        if message.is_null() {
            return Some(format!("error {code}"));
        }
        // SAFETY: the library gives a text with an end, which lives until the next call.
        Some(unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned())
    }

    /// Filters images of `size` (width and height, pixels): `output` becomes the first of `inputs`, which the library knows by their names, without
    /// noise.
    ///
    /// # Errors
    /// What the library says went wrong; `output` may hold anything then.
    ///
    /// # Panics
    /// If an image is not of that size.
    pub fn filter(
        &self,
        [width, height]: [usize; 2],
        inputs: &[(&CStr, &[f32])],
        output: &mut [f32],
        settings: FilterSettings,
    ) -> Result<(), String> {
        let numbers = width.checked_mul(height).and_then(|pixels| pixels.checked_mul(3));
        let images = inputs.iter().map(|(_, image)| image.len()).chain([output.len()]);
        assert!(images.into_iter().all(|length| Some(length) == numbers), "an image is not of the size {width}x{height}");
        let f = self.functions;
        // SAFETY: the device is valid, the name a text with an end.
        let filter = unsafe { (f.new_filter)(self.handle, c"RT".as_ptr()) };
        if filter.is_null() {
            return Err(self.error().unwrap_or_else(|| "there is no such filter".to_owned()));
        }
        let set_image = |name: &CStr, image: *mut f32| {
            // SAFETY: the filter is valid, the name a text with an end; the image has three floats for each pixel, without gaps (which the zeros
            // say), and outlives the filter.
            unsafe { (f.set_shared_image)(filter, name.as_ptr(), image.cast(), FLOAT3, width, height, 0, 0, 0) }
        };
        for (name, image) in inputs {
            // The library does not write to its inputs.
            set_image(name, image.as_ptr().cast_mut());
        }
        set_image(c"output", output.as_mut_ptr());
        // SAFETY: the filter is valid, the names are texts with an end; while it is executed nobody else uses the output, which is borrowed for
        // that, and nobody changes the inputs. It is not used after it is released.
        unsafe {
            (f.set_filter_bool)(filter, c"hdr".as_ptr(), settings.hdr);
            (f.set_filter_bool)(filter, c"cleanAux".as_ptr(), settings.clean_guides);
            (f.set_filter_int)(filter, c"maxMemoryMB".as_ptr(), c_int::from(settings.most_megabytes));
            (f.commit_filter)(filter);
            (f.execute_filter)(filter);
            (f.release_filter)(filter);
        }
        self.error().map_or(Ok(()), Err)
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: it is valid, and not used again.
            unsafe { (self.functions.release_device)(self.handle) };
        }
    }
}

//! Intel's Embree 4 through embree4-sys: the fast intersector, and one of the two files of the project with unsafe code.
//!
//! Embree works in single precision. Segments are therefore brought near the scene and to a sensible length first, and the
//! parameter of a triangle's hit is good to some 1e-7 of the coordinates; analytic surfaces see the segment itself, in
//! double precision. Both ends of a segment are rounded so: two chords that are to leave no gap must overlap by more.
//!
//! Where surfaces touch or nearly touch (`contacts`) single precision cannot tell which comes first. A query that begins or ends
//! there is answered exactly: the primitives that come so near to others are put to `exact`, all others to Embree.
//!
//! An object that stands in the scene many times is an Embree scene of its own, instanced: its triangles and their hierarchy are
//! there once.
//!
//! What embree4-rs does not give: queries without asking for the device's error each time, occlusion, surfaces other than
//! triangles, scenes that can be sent to threads. It stays as an oracle in the tests.
//!
//! ```bhs
//! Option "string intersector" "embree"
//! WorldBegin
//! ```
#![allow(unsafe_code)] // a foreign interface; each block says why it is sound

use crate::contacts::Contacts;
use crate::crowds::{Crowds, Guarded, SinglePrecision};
use crate::query::{CONFIGURATION, Query, Surface, primitive_of};
use crate::single::{Room, UNWRITTEN, clamp};
use bhs_core::Plugin;
use bhs_core::geometry::instance::Object;
use bhs_core::geometry::{Aabb, Geometry, Segment, TriangleMesh};
use bhs_core::intersector::{Intersector, IntersectorBuilder, Primitive, PrimitiveHit};
use embree4_sys::*;
use glam::DAffine3;
use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_void};
use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn IntersectorBuilder> =
    Plugin { name: "embree", summary: "Intel's Embree 4: fast, single precision", build: |_| Some(Box::new(Embree)) };

/// Builder of Embree scenes.
pub struct Embree;

// Measured on the 871,414-triangle dragon, two cores busy with other work, processor time of one thread, Embree 4.4 (AVX2);
// closest hit of a ray | of a chord 1/16 as long as the box, 1e6 of them from random points of the box:
//
//   ROBUST            424 ns | 251 ns    65 MB and 0.6 s of processor time to build
//   ROBUST, COMPACT   958 ns | 458 ns    37 MB,    0.7 s
//   neither           381 ns | 210 ns    65 MB,    0.8 s
//
// Without ROBUST rays leak through shared edges, which a closed room must not allow. The quality LOW or HIGH changed nothing
// with ROBUST; without it, HIGH took 2.4 s to build and gained nothing.
const FLAGS: RTCSceneFlags = RTCSceneFlags::ROBUST;
const QUALITY: RTCBuildQuality = RTCBuildQuality::MEDIUM;

impl IntersectorBuilder for Embree {
    fn build(&self, geometries: &[Geometry]) -> Result<Box<dyn Intersector>, String> {
        crate::check(geometries)?;
        let boxes: Vec<Option<Aabb>> = geometries.iter().map(|g| clamp(g.bounds())).collect();
        let room = Room::new(boxes.iter().flatten().fold(Aabb::EMPTY, |all, b| all.union(*b)));

        let crowds = Crowds::find(geometries);
        let flags = if crowds.is_some() { FLAGS | RTCSceneFlags::FILTER_FUNCTION_IN_ARGUMENTS } else { FLAGS };
        let device = Device::new()?;
        let handle = Handle::scene(&device, flags);
        let mut scene = Scene { scene: handle, surfaces: Vec::new(), meshes: Vec::new(), device, room };
        let objects: HashMap<*const Object, Handle> = crate::objects(geometries)
            .into_iter()
            .map(|(_, object)| (Arc::as_ptr(object), Handle::object(&scene.device, object, flags, &mut scene.meshes)))
            .collect();
        for ((id, geometry), bounds) in (0u32..).zip(geometries).zip(boxes) {
            let Some(bounds) = bounds else { continue };
            match geometry {
                Geometry::Mesh(mesh) => {
                    scene.scene.attach_mesh(&scene.device, id, mesh);
                    scene.meshes.push(mesh.clone());
                }
                Geometry::Analytic(surface) => {
                    let surface = Arc::new(Surface { surface: surface.clone(), bounds: scene.room.single_bounds(bounds) });
                    scene.scene.attach_surface(&scene.device, id, &surface);
                    scene.surfaces.push(surface);
                }
                // The other meshes of the object come with the first, numbered as here.
                Geometry::Instance(instance) if instance.part() == 0 => {
                    if let Some(object) = objects.get(&Arc::as_ptr(instance.object())) {
                        scene.scene.attach_object(&scene.device, id, object, instance.render_from_own());
                    }
                }
                Geometry::Instance(_) => {}
            }
        }
        scene.scene.commit();
        scene.device.check()?;
        Ok(Box::new(Guarded { scene, crowds }))
    }
}

// ---- Embree's objects and who owns them ----

/// The text of the first error.
type FirstError = Mutex<Option<String>>;

/// An Embree device; each scene has its own, so that nothing is shared between scenes.
struct Device {
    handle: RTCDevice,
    error: Arc<FirstError>,
}

impl Device {
    fn new() -> Result<Self, String> {
        let error = Arc::new(FirstError::default());
        // SAFETY: the configuration is a text that ends in NUL.
        let handle = unsafe { rtcNewDevice(CONFIGURATION.as_ptr()) };
        if handle.is_null() {
            return Err("Embree cannot start".to_owned());
        }
        // SAFETY: `error` outlives the device: both are fields of the value returned, whose drop releases the device first.
        unsafe { rtcSetDeviceErrorFunction(handle, Some(record_error), Arc::as_ptr(&error) as *mut c_void) };
        Ok(Self { handle, error })
    }

    /// What went wrong since the device was made. Queries are not checked one by one: a scene that was built has none to report.
    fn check(&self) -> Result<(), String> {
        match self.error.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(text) => Err(format!("Embree: {text}")),
            None => Ok(()),
        }
    }
}

/// The version of the library that is loaded: 40400 is 4.4.0.
pub fn version() -> Option<i64> {
    // SAFETY: the device is live. What it returns is `ssize_t`, which bindings write as one type or another, by the system.
    Device::new().ok().map(|device| unsafe { rtcGetDeviceProperty(device.handle, RTCDeviceProperty::VERSION) as i64 })
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the handle is live and released only here.
        unsafe { rtcReleaseDevice(self.handle) };
    }
}

/// Called by Embree, from any of its threads, when a call fails.
unsafe extern "C" fn record_error(first: *mut c_void, code: RTCError, text: *const c_char) {
    // SAFETY: `first` is what `Device::new` registered, and lives as long as the device.
    let first = unsafe { &*(first as *const FirstError) };
    // SAFETY: Embree hands over a string that ends in NUL, or nothing.
    let text = if text.is_null() { "".into() } else { unsafe { CStr::from_ptr(text) }.to_string_lossy() };
    first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| format!("{text} ({code:?})"));
}

/// An Embree scene.
struct Handle(RTCScene);

impl Handle {
    fn scene(device: &Device, flags: RTCSceneFlags) -> Self {
        // SAFETY: the device is live; Embree keeps it alive for the scene by counting references, and reports a scene that is null.
        unsafe {
            let scene = rtcNewScene(device.handle);
            rtcSetSceneFlags(scene, flags);
            rtcSetSceneBuildQuality(scene, QUALITY);
            Self(scene)
        }
    }

    /// Adds a mesh. It must be kept for as long as the scene.
    fn attach_mesh(&self, device: &Device, id: u32, mesh: &Arc<TriangleMesh>) {
        let (vertices, triangles) = (&mesh.positions, &mesh.triangles);
        // SAFETY: the device is live; the triangles are shared with Embree, unchanged and in place while the caller keeps the
        // `Arc`; they name existing vertices (`crate::check`). The vertices are copied, because Embree reads 16 bytes at
        // each, of which four would lie behind the end of ours.
        unsafe {
            let geometry = rtcNewGeometry(device.handle, RTCGeometryType::TRIANGLE);
            let copy = rtcSetNewGeometryBuffer(geometry, RTCBufferType::VERTEX, 0, RTCFormat::FLOAT3, 12, vertices.len());
            if !copy.is_null() {
                ptr::copy_nonoverlapping(vertices.as_ptr(), copy as *mut [f32; 3], vertices.len());
                let data = triangles.as_ptr() as *const c_void;
                rtcSetSharedGeometryBuffer(geometry, RTCBufferType::INDEX, 0, RTCFormat::UINT3, data, 0, 12, triangles.len());
                self.attach(geometry, id);
            }
            rtcReleaseGeometry(geometry);
        }
    }

    /// A committed scene of the meshes of an object, numbered in their order. They are added to `meshes`, to be kept.
    fn object(device: &Device, object: &Object, flags: RTCSceneFlags, meshes: &mut Vec<Arc<TriangleMesh>>) -> Self {
        let scene = Self::scene(device, flags);
        for (id, mesh) in (0u32..).zip(object.meshes()) {
            scene.attach_mesh(device, id, mesh);
            meshes.push(mesh.clone());
        }
        scene.commit();
        scene
    }

    /// Adds an object, whose meshes get the numbers from `id` on.
    fn attach_object(&self, device: &Device, id: u32, object: &Handle, to_here: &DAffine3) {
        let [x, y, z, w] = [to_here.x_axis, to_here.y_axis, to_here.z_axis, to_here.translation].map(|c| c.as_vec3().to_array());
        let columns = [x, y, z, w];
        // SAFETY: device and object are live, the object is committed; the matrix is twelve numbers, column after column, which Embree
        // copies. The instance keeps the object's scene by counting references.
        unsafe {
            let geometry = rtcNewGeometry(device.handle, RTCGeometryType::INSTANCE);
            rtcSetGeometryInstancedScene(geometry, object.0);
            rtcSetGeometryTransform(geometry, 0, RTCFormat::FLOAT3X4_COLUMN_MAJOR, columns.as_ptr().cast());
            self.attach(geometry, id);
            rtcReleaseGeometry(geometry);
        }
    }

    /// Adds an analytic surface. It must be kept for as long as the scene.
    fn attach_surface(&self, device: &Device, id: u32, surface: &Arc<Surface>) {
        // SAFETY: the device is live; the callbacks get a pointer to the surface, which the caller keeps in place.
        unsafe {
            let geometry = rtcNewGeometry(device.handle, RTCGeometryType::USER);
            rtcSetGeometryUserPrimitiveCount(geometry, 1);
            rtcSetGeometryUserData(geometry, Arc::as_ptr(surface) as *mut c_void);
            rtcSetGeometryBoundsFunction(geometry, Some(surface_bounds), ptr::null_mut());
            rtcSetGeometryIntersectFunction(geometry, Some(surface_intersect));
            rtcSetGeometryOccludedFunction(geometry, Some(surface_occluded));
            self.attach(geometry, id);
            rtcReleaseGeometry(geometry);
        }
    }

    /// # Safety
    /// The geometry must be complete.
    unsafe fn attach(&self, geometry: RTCGeometry, id: u32) {
        // SAFETY: the scene is live and each number is given once. The scene keeps the geometry by counting references.
        unsafe {
            rtcCommitGeometry(geometry);
            rtcAttachGeometryByID(self.0, geometry, id);
        }
    }

    fn commit(&self) {
        // SAFETY: the scene is live, and no thread queries it yet.
        unsafe { rtcCommitScene(self.0) };
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: the handle is live and released only here.
        unsafe { rtcReleaseScene(self.0) };
    }
}

// ---- Queries ----

/// A committed scene with all that Embree has pointers to.
struct Scene {
    // Dropped in this order: the scene, then what it refers to, then the device.
    scene: Handle,
    surfaces: Vec<Arc<Surface>>,
    meshes: Vec<Arc<TriangleMesh>>,
    device: Device,
    room: Room,
}

// SAFETY: the handles are not bound to a thread. Nothing changes a scene after it is committed, and Embree allows any number
// of threads to query such a scene; what the callbacks read is `Sync`, what they write belongs to the query.
unsafe impl Send for Scene {}
// SAFETY: as above.
unsafe impl Sync for Scene {}

/// Embree 4.3 and newer write one number more than the headers of embree4-sys know of.
#[repr(C)]
struct RayHit {
    known: RTCRayHit,
    _room: [u32; 4],
}

impl SinglePrecision for Scene {
    /// What Embree finds first, leaving out the primitives of `without`.
    #[inline(always)]
    fn find(&self, segment: &Segment, without: Option<&Contacts>) -> Option<PrimitiveHit> {
        let mut found = RayHit { known: RTCRayHit { ray: UNWRITTEN, hit: RTCHit::default() }, _room: [0; 4] };
        let scale = self.room.cast(segment, &mut found.known.ray)?;
        let target = (&raw mut found).cast();
        let mut nearest = None;
        if self.surfaces.is_empty() && without.is_none() {
            // SAFETY: the scene is committed; `found` is large enough and aligned; null arguments mean the defaults.
            unsafe { rtcIntersect1(self.scene.0, target, ptr::null_mut()) };
        } else {
            let mut query = Query::new(segment, scale, without);
            let mut arguments = RTCIntersectArguments {
                flags: query.flags(),
                feature_mask: RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
                context: (&raw mut query).cast(),
                filter: without.map(|_| leave_out as _),
                intersect: None,
            };
            // SAFETY: as above; the context is a `Query`, as the callbacks expect, and nobody else uses it meanwhile.
            unsafe { rtcIntersect1(self.scene.0, target, &mut arguments) };
            nearest = Some(query.finish());
        }
        let RTCRayHit { ray, hit } = &found.known;
        if hit.geomID == RTC_INVALID_GEOMETRY_ID {
            return None;
        }
        // Embree's parameter is that of the nearest analytic surface exactly if no triangle is nearer.
        let t = nearest.filter(|t| scale.tfar(*t) == ray.tfar).unwrap_or_else(|| scale.t(ray.tfar));
        let Primitive { geometry, primitive } = primitive_of(hit);
        Some(PrimitiveHit { t: t.max(segment.t_min).min(segment.t_max), geometry, primitive, is_crowded: false })
    }

    /// Whether Embree finds anything, leaving out the primitives of `without`.
    #[inline(always)]
    fn find_any(&self, segment: &Segment, without: Option<&Contacts>) -> bool {
        let mut ray = UNWRITTEN;
        let Some(scale) = self.room.cast(segment, &mut ray) else { return false };
        if self.surfaces.is_empty() && without.is_none() {
            // SAFETY: the scene is committed; null arguments mean the defaults.
            unsafe { rtcOccluded1(self.scene.0, &mut ray, ptr::null_mut()) };
        } else {
            let mut query = Query::new(segment, scale, without);
            let mut arguments = RTCOccludedArguments {
                flags: query.flags(),
                feature_mask: RTCFeatureFlags::RTC_FEATURE_FLAG_ALL,
                context: (&raw mut query).cast(),
                filter: without.map(|_| leave_out as _),
                occluded: None,
            };
            // SAFETY: as above; the context is a `Query`, as the callbacks expect, and nobody else uses it meanwhile.
            unsafe { rtcOccluded1(self.scene.0, &mut ray, &mut arguments) };
            query.finish();
        }
        ray.tfar == f32::NEG_INFINITY
    }
}

/// Called by Embree, on the thread of a query, for each hit on a triangle of a query that leaves some out.
unsafe extern "C" fn leave_out(arguments: *const RTCFilterFunctionNArguments) {
    // SAFETY: Embree passes valid arguments; the context is the `Query` of `find` or `find_any`, and N is 1, for which the hit is laid out
    // as an `RTCHit`.
    unsafe {
        let arguments = &*arguments;
        let query = &*(arguments.context as *const Query);
        let hit = &*(arguments.hit as *const RTCHit);
        if query.without.is_some_and(|contacts| contacts.involves(primitive_of(hit))) {
            *arguments.valid = 0;
        }
    }
}

// ---- Analytic surfaces ----

/// Called by Embree, from any of its threads, when it builds a scene.
unsafe extern "C" fn surface_bounds(arguments: *const RTCBoundsFunctionArguments) {
    // SAFETY: Embree passes valid arguments; the pointer of the geometry is the `Surface` that `attach_surface` set.
    unsafe {
        let arguments = &*arguments;
        *arguments.bounds_o = (*(arguments.geometryUserPtr as *const Surface)).bounds;
    }
}

/// Called by Embree within `rtcIntersect1`, on the same thread.
unsafe extern "C" fn surface_intersect(arguments: *const RTCIntersectFunctionNArguments) {
    // SAFETY: Embree passes valid arguments; the pointer of the geometry is the `Surface` that `attach_surface` set, the
    // context the `Query` of `closest`, and N is 1, for which the ray is a plain `RTCRayHit`.
    unsafe {
        let arguments = &*arguments;
        if *arguments.valid == 0 {
            return;
        }
        let surface = &*(arguments.geometryUserPtr as *const Surface);
        let query = &mut *(arguments.context as *mut Query);
        let found = arguments.rayhit as *mut RTCRayHit;
        if query.leaves_out(arguments.geomID) {
            return;
        }
        if let Some(t) = query.meet(surface, (*found).ray.tfar) {
            query.nearest = t;
            (*found).ray.tfar = query.scale.tfar(t);
            (*found).hit.geomID = arguments.geomID;
            // A farther triangle that was found before may have been one of an object's.
            (*found).hit.instID = [RTC_INVALID_GEOMETRY_ID];
            (*found).hit.primID = arguments.primID;
        }
    }
}

/// Called by Embree within `rtcOccluded1`, on the same thread.
unsafe extern "C" fn surface_occluded(arguments: *const RTCOccludedFunctionNArguments) {
    // SAFETY: as in `surface_intersect`, with the `Query` of `blocked` and a plain `RTCRay`.
    unsafe {
        let arguments = &*arguments;
        if *arguments.valid == 0 {
            return;
        }
        let surface = &*(arguments.geometryUserPtr as *const Surface);
        let query = &mut *(arguments.context as *mut Query);
        let ray = arguments.ray as *mut RTCRay;
        if !query.leaves_out(arguments.geomID) && query.meet(surface, (*ray).tfar).is_some() {
            (*ray).tfar = f32::NEG_INFINITY;
        }
    }
}

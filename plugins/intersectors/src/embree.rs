//! Intel's Embree 4 through embree4-sys: the fast intersector, and the only file of the project with unsafe code.
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
use crate::exact::Exact;
use crate::single::{Room, Scale, UNWRITTEN, clamp};
use bhs_core::Plugin;
use bhs_core::geometry::{Aabb, Analytic, Geometry, Segment, TriangleMesh};
use bhs_core::instance::Object;
use bhs_core::intersector::{Ends, Intersector, IntersectorBuilder, Primitive, PrimitiveHit, SHADOW_END};
use embree4_sys::*;
use glam::{DAffine3, DVec3};
use std::any::Any;
use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
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

        let crowds = Contacts::find(geometries).map(|contacts| {
            let exact = Exact::new(geometries, contacts.with_neighbours(geometries));
            Crowds { contacts, exact, geometries: geometries.to_vec() }
        });
        let flags = if crowds.is_some() { FLAGS | RTCSceneFlags::FILTER_FUNCTION_IN_ARGUMENTS } else { FLAGS };
        let device = Device::new()?;
        let handle = Handle::scene(&device, flags);
        let mut scene = Scene { scene: handle, surfaces: Vec::new(), meshes: Vec::new(), crowds, device, room };
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
        Ok(Box::new(scene))
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
        // SAFETY: a null configuration means the defaults.
        let handle = unsafe { rtcNewDevice(ptr::null()) };
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
        // SAFETY: the device is live. Embree keeps it alive for the scene by counting references.
        let scene = unsafe { rtcNewScene(device.handle) };
        // SAFETY: the scene is live, or null, which Embree reports through the device.
        unsafe {
            rtcSetSceneFlags(scene, flags);
            rtcSetSceneBuildQuality(scene, QUALITY);
        }
        Self(scene)
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
    crowds: Option<Crowds>,
    device: Device,
    room: Room,
}

/// Where surfaces are close together, and what tells them apart there.
struct Crowds {
    contacts: Contacts,
    exact: Exact,
    geometries: Vec<Geometry>,
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

/// The context of a query over more than meshes. Embree only looks at its beginning.
#[repr(C)]
struct Query<'a> {
    /// The place of Embree's own context, which consists of instance numbers: two in 4.4, room for more.
    ids: [u32; 8],
    segment: &'a Segment,
    scale: Scale,
    /// Parameter of the nearest analytic surface so far, of the segment's end before.
    nearest: f64,
    /// Whose primitives are left out, because [`Exact`] looks at them.
    without: Option<&'a Contacts>,
    /// What a surface panicked with: unwinding must not reach Embree.
    panic: Option<Box<dyn Any + Send>>,
}

const _: () = assert!(size_of::<RTCRayQueryContext>() <= size_of::<[u32; 8]>());

impl Intersector for Scene {
    fn closest(&self, segment: &Segment) -> Option<PrimitiveHit> {
        let found = self.find(segment, None);
        let Some(crowds) = &self.crowds else { return found };
        if crowds.is_in_doubt(segment, found.as_ref()) { self.closest_exactly(crowds, segment, None) } else { found }
    }

    fn blocked(&self, segment: &Segment) -> bool {
        self.find_any(segment, None) || self.slips_through(segment)
    }

    fn closest_from(&self, segment: &Segment, leaving: Option<Primitive>) -> Option<PrimitiveHit> {
        match &self.crowds {
            Some(crowds) => self.closest_exactly(crowds, segment, leaving),
            None => self.closest(segment),
        }
    }

    fn blocked_between(&self, segment: &Segment, ends: Ends) -> bool {
        if let Some(crowds) = &self.crowds {
            let is_crowded = |p| crowds.contacts.involves(p) && crowds.contacts.is_crowded(segment.at(segment.t_max));
            let end_is_crowded = || ends.target.is_some_and(is_crowded);
            if ends.leaving.is_some() || end_is_crowded() {
                return self.blocked_exactly(crowds, segment, ends);
            }
        }
        self.blocked(&shortened(segment, ends))
    }

    fn is_crowded(&self, point: DVec3) -> bool {
        self.crowds.as_ref().is_some_and(|crowds| crowds.contacts.is_crowded(point))
    }
}

/// A segment without the part just before the primitive on which it ends, if it does.
fn shortened(segment: &Segment, ends: Ends) -> Segment {
    Segment { t_max: if ends.target.is_some() { SHADOW_END * segment.t_max } else { segment.t_max }, ..*segment }
}

impl Crowds {
    /// Whether something else than what was `found` may come first: another surface near that or near the start, or one where surfaces meet at edges that
    /// they do not share, between which single precision may have let the segment through.
    #[inline]
    fn is_in_doubt(&self, segment: &Segment, found: Option<&PrimitiveHit>) -> bool {
        found.is_some_and(|hit| self.contacts.is_crowded(segment.at(hit.t)))
            || self.contacts.is_crowded(segment.origin)
            || self.contacts.may_slip_through(&Segment { t_max: found.map_or(segment.t_max, |hit| hit.t), ..*segment })
    }
}

impl Scene {
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

    /// Whether a segment that Embree finds free is blocked where it may have slipped through between two surfaces.
    #[inline]
    fn slips_through(&self, segment: &Segment) -> bool {
        let crowds = self.crowds.as_ref().filter(|crowds| crowds.contacts.may_slip_through(segment));
        crowds.is_some_and(|crowds| self.blocked_exactly(crowds, segment, Ends::default()))
    }

    /// The first surface along a segment that passes where surfaces are close together, or leaves a primitive there.
    #[cold]
    fn closest_exactly(&self, crowds: &Crowds, segment: &Segment, leaving: Option<Primitive>) -> Option<PrimitiveHit> {
        let close = crowds.exact.closest(segment, leaving);
        let t_max = close.map_or(segment.t_max, |hit| hit.t);
        let others = Segment { t_max, ..self.off_surface(crowds, segment, leaving) };
        let hit = self.find(&others, Some(&crowds.contacts)).or(close)?;
        let primitive = Primitive { geometry: hit.geometry, primitive: hit.primitive };
        let is_crowded = crowds.contacts.involves(primitive) && crowds.contacts.is_crowded(segment.at(hit.t));
        Some(PrimitiveHit { is_crowded, ..hit })
    }

    /// Whether anything stands in such a segment's way.
    #[cold]
    fn blocked_exactly(&self, crowds: &Crowds, segment: &Segment, ends: Ends) -> bool {
        let others = || shortened(&self.off_surface(crowds, segment, ends.leaving), ends);
        crowds.exact.blocked(segment, ends) || self.find_any(&others(), Some(&crowds.contacts))
    }

    /// The segment moved off the primitive that it leaves: what is not in the zones is farther away than that.
    fn off_surface(&self, crowds: &Crowds, segment: &Segment, leaving: Option<Primitive>) -> Segment {
        let Some(Primitive { geometry, primitive }) = leaving else { return *segment };
        let geometry = &crowds.geometries[geometry as usize];
        let normal = geometry.normal(primitive, segment.origin);
        let side = if normal.dot(segment.direction) < 0.0 { -normal } else { normal };
        Segment { origin: segment.origin + side * geometry.step_off(primitive), ..*segment }
    }
}

/// The numbers of a primitive that was hit. A mesh of an object has its number there, and the object that of its first mesh here.
fn primitive_of(hit: &RTCHit) -> Primitive {
    let [object] = hit.instID;
    let geometry = if object == RTC_INVALID_GEOMETRY_ID { hit.geomID } else { object + hit.geomID };
    Primitive { geometry, primitive: hit.primID }
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

/// An analytic surface as Embree's user geometry.
struct Surface {
    surface: Arc<dyn Analytic>,
    bounds: RTCBounds,
}

impl<'a> Query<'a> {
    fn new(segment: &'a Segment, scale: Scale, without: Option<&'a Contacts>) -> Self {
        let ids = [RTC_INVALID_GEOMETRY_ID; 8];
        Self { ids, segment, scale, nearest: segment.t_max, without, panic: None }
    }

    fn flags(&self) -> RTCRayQueryFlags {
        match self.without {
            Some(_) => RTCRayQueryFlags::INCOHERENT | RTCRayQueryFlags::INVOKE_ARGUMENT_FILTER,
            None => RTCRayQueryFlags::INCOHERENT,
        }
    }

    /// The parameter of the nearest analytic surface, after the query; goes on with a panic of a surface.
    fn finish(self) -> f64 {
        match self.panic {
            Some(payload) => resume_unwind(payload),
            None => self.nearest,
        }
    }

    /// Whether an analytic surface is left out.
    fn leaves_out(&self, geometry: u32) -> bool {
        self.without.is_some_and(|contacts| contacts.involves(Primitive { geometry, primitive: 0 }))
    }

    /// Where the segment meets the surface before Embree's parameter `tfar`.
    fn meet(&mut self, surface: &Surface, tfar: f32) -> Option<f64> {
        let t_max = self.nearest.min(self.scale.t(tfar));
        let segment = Segment { t_max, ..*self.segment };
        let t = match catch_unwind(AssertUnwindSafe(|| surface.surface.intersect(&segment))) {
            Ok(t) => t,
            Err(payload) => {
                self.panic = Some(payload);
                None
            }
        };
        t.filter(|t| segment.t_min < *t && *t < t_max)
    }
}

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

//! A query of Embree as its callbacks see it, and the analytic surfaces that they look at: all of it that needs no unsafe code.

use crate::contacts::Contacts;
use crate::single::Scale;
use bhs_core::geometry::{Analytic, Segment};
use bhs_core::intersector::Primitive;
use embree4_sys::{RTC_INVALID_GEOMETRY_ID, RTCBounds, RTCHit, RTCRayQueryContext, RTCRayQueryFlags};
use std::any::Any;
use std::ffi::CStr;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

/// What Embree's devices are told.
///
/// Embree picks code by the processor, and code with fused multiply-adds rounds otherwise: `spheres` saw some rays meet other surfaces. All processors of
/// this architecture that bhs runs on have these instructions, so that all find the same. One ray at a time gains nothing by wider ones: `gold_dragon` took
/// 1.00 times the processor time of the default (AVX-512), medians of five in turn.
pub(crate) const CONFIGURATION: &CStr = if cfg!(target_arch = "x86_64") { c"isa=sse4.2" } else { c"" };

/// The context of a query over more than meshes. Embree only looks at its beginning.
#[repr(C)]
pub(crate) struct Query<'a> {
    /// The place of Embree's own context, which consists of instance numbers: two in 4.4, room for more.
    ids: [u32; 8],
    segment: &'a Segment,
    pub scale: Scale,
    /// Parameter of the nearest analytic surface so far, of the segment's end before.
    pub nearest: f64,
    /// Whose primitives are left out, because [`Exact`] looks at them.
    pub without: Option<&'a Contacts>,
    /// What a surface panicked with: unwinding must not reach Embree.
    panic: Option<Box<dyn Any + Send>>,
}

const _: () = assert!(size_of::<RTCRayQueryContext>() <= size_of::<[u32; 8]>());

/// The numbers of a primitive that was hit. A mesh of an object has its number there, and the object that of its first mesh here.
pub(crate) fn primitive_of(hit: &RTCHit) -> Primitive {
    let [object] = hit.instID;
    let geometry = if object == RTC_INVALID_GEOMETRY_ID { hit.geomID } else { object + hit.geomID };
    Primitive { geometry, primitive: hit.primID }
}

/// An analytic surface as Embree's user geometry.
pub(crate) struct Surface {
    pub surface: Arc<dyn Analytic>,
    pub bounds: RTCBounds,
}

impl<'a> Query<'a> {
    pub fn new(segment: &'a Segment, scale: Scale, without: Option<&'a Contacts>) -> Self {
        let ids = [RTC_INVALID_GEOMETRY_ID; 8];
        Self { ids, segment, scale, nearest: segment.t_max, without, panic: None }
    }

    pub fn flags(&self) -> RTCRayQueryFlags {
        match self.without {
            Some(_) => RTCRayQueryFlags::INCOHERENT | RTCRayQueryFlags::INVOKE_ARGUMENT_FILTER,
            None => RTCRayQueryFlags::INCOHERENT,
        }
    }

    /// The parameter of the nearest analytic surface, after the query; goes on with a panic of a surface.
    pub fn finish(self) -> f64 {
        match self.panic {
            Some(payload) => resume_unwind(payload),
            None => self.nearest,
        }
    }

    /// Whether an analytic surface is left out.
    pub fn leaves_out(&self, geometry: u32) -> bool {
        self.without.is_some_and(|contacts| contacts.involves(Primitive { geometry, primitive: 0 }))
    }

    /// Where the segment meets the surface before Embree's parameter `tfar`.
    pub fn meet(&mut self, surface: &Surface, tfar: f32) -> Option<f64> {
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

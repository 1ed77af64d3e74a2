/* Makes room for what newer Embree versions write.
 *
 * embree4-sys brings the headers of Embree 4.2. Since 4.3 a hit has one more field, instPrimID, so that the library
 * writes 4 bytes (times the packet size) behind the end of 4.2's RTCRayHit on every hit, onto the caller's stack. These
 * declarations, which setup.py puts in front of the headers through BINDGEN_EXTRA_CLANG_ARGS, give the structs an
 * alignment large enough that the padding at their end covers the missing field. Fields and offsets stay as they are.
 */
struct __attribute__((aligned(32))) RTCRayHit;       /* 80 -> 96 bytes, needed: 84 */
struct __attribute__((aligned(128))) RTCRayHit4;     /* 320 -> 384, needed: 336 */
struct __attribute__((aligned(256))) RTCRayHit8;     /* 640 -> 768, needed: 672 */
struct __attribute__((aligned(512))) RTCRayHit16;    /* 1280 -> 1536, needed: 1344 */
struct __attribute__((aligned(8))) RTCRayQueryContext; /* 4 -> 8 */

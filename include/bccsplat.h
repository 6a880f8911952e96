/* SPDX-License-Identifier: Apache-2.0 */
/* bccsplat: time-varying volumes on the D4* lattice. Store, slice, splat.
 *
 * This header is the manual. Conventions that hold everywhere are stated here once.
 *
 * SPACES
 *
 * - index space: (x, y, z, t). Sample i of the source stands at coordinate i on every axis; t
 *   counts frames and may be fractional. The domain is [0, n-1] on every axis, and [0, n] on one
 *   that is periodic, in space or time (n is sample 0 again); nothing is drawn or evaluated outside
 *   it.
 * - slice space: (u, v, w) of a slice. For a time slice it is index space without t. For other
 *   hyperplanes the slice states its origin and orthonormal basis in index space.
 * - world space: right-handed, in the volume's spatial unit. A 4x4 row-major affine m (last row 0 0
 *   0 1) takes the column (x, y, z, 1) of index space to it: world x = m[0] x + m[1] y + m[2] z +
 *   m[3], the translation in m[3], m[7], m[11]. Cameras, lights and unit_distance are in world
 *   space.
 * - even positions: of a volume whose samples are unevenly spaced along an axis of space
 *   (bccsplat_axis). They run from 0 to n-1 like indices, in proportion to the coordinates of the
 *   samples, monotone cubic between these (formats/bcc4.md, record 0x8009). The affine takes them
 *   to the world; of indices it holds at the corners of the domain alone, as older files and hosts
 *   have it, whose spatial unit is therefore "". Along other axes they are the indices. Where this
 *   header says index space it means indices, also for the errors and bounds of a file;
 *   BCCSPLAT_SPACE_EVEN alone asks for even positions.
 * - time: in the volume's time unit. Frames may be unevenly spaced; times rise strictly.
 * - T: the lattice distance, that of the source samples unless a scale says otherwise; lengths of
 *   kernels and sheet steps are in T. Sites of D4* and BCC stand in two shifted grids, each sparser
 *   by sqrt2 along its axes than T, or a little less, so that planes end on the last sample
 *   (bccsplat_layer_geometry.step: 1.39 at 24 samples); layers of D4* follow each other at T /
 *   sqrt2 in time. Where distances differ, T is as long along each axis as its own, and what
 *   depends on pixels per T goes by the direction of most. Between samples, thick slices above all,
 *   a field rings where the source jumps: by some 5 to 15 % of the jump with every kernel that goes
 *   through the samples. With the kernel "paper" a file of lattice CC stays within the range of the
 *   samples in its reach, and blurs instead.
 *
 * ARRAYS: x is fastest, then y, z, t. Sizes are counts of elements unless the name says bytes. A
 * count of more than 2^57 bytes is INVALID_ARGUMENT. A capacity may be any number, UINT64_MAX
 * included. Arrays and structs are aligned as C aligns their type (a float at a multiple of 4
 * bytes, a double or uint64_t of 8); data passed as void* (samples of a bccsplat_box, the bytes of
 * a file) may begin at any address, with strides of any number of bytes.
 *
 * NUMBERS that a host hands in are finite, and unless their text says otherwise at most 1e30 in
 * magnitude; values of fields (air, ranges, steps, bounds, those of transfer functions and
 * isosurfaces) are those of a float, up to 3.4e38; colours and what multiplies them 0 to 1e9.
 * Others are INVALID_ARGUMENT, at the call that takes them, with the name of the field in the text.
 * The samples of a source are checked as writer_options.nonfinite says; a requested point or time
 * outside the domain, or NaN, is OUT_OF_DOMAIN.
 *
 * IMAGES: origin top left, row 0 is the top. Colour is linear, premultiplied by opacity. Opacity of
 * a transfer function is the fraction absorbed per unit_distance of world length.
 *
 * STRINGS: UTF-8, zero-terminated; a string to be written into a file that is not UTF-8 is
 * INVALID_ARGUMENT. Paths are UTF-8 on Windows, elsewhere the bytes that the system's own calls
 * take. Strings that come from an object live as long as the object.
 *
 * STRUCTS begin with struct_size, set by the caller to sizeof(the struct), also in output structs:
 * BCCSPLAT_INIT in C, sized() of bccsplat.hpp in C++. A cleared struct (all zero apart from
 * struct_size) asks for the defaults; structs and fields without defaults (a box, a stream, a
 * camera, a transfer function, dims) must be filled in by the caller. A field whose zero is a
 * meaningful choice counts only if its bit stands in set_mask. Structs grow only at the end: a
 * caller built against an older header gets the older behaviour; a non-zero tail this library does
 * not know is INVALID_STRUCT_SIZE, and so is a size below 8 and one of an input above 65536. The
 * library writes at most struct_size bytes of an output struct, and at most those that it knows:
 * the rest of a larger struct stays as it was. struct_size stays.
 *
 * STATUS: every call that can fail returns a bccsplat_status. On failure output handles are NULL
 * (what the variable held before is overwritten in any case, not released) and other outputs are
 * untouched unless the call says otherwise; what a call fills as it goes (values, gradients,
 * points) may hold anything after it failed at work; bccsplat_last_error() has the text. Any call
 * may return INVALID_ARGUMENT (a NULL or senseless argument), INVALID_STRUCT_SIZE, INVALID_HANDLE,
 * OUT_OF_MEMORY, MEMORY_BUDGET or INTERNAL; one with a token or a callback that can stop it
 * CANCELLED; one on a renderer or writer WRONG_STATE (see THREADS). A call's comment lists what
 * else it may return behind "Also:". There "reading" stands for IO, CORRUPT, TRUNCATED,
 * CHECKSUM_MISMATCH, LIMIT_EXCEEDED and of streams WOULD_BLOCK, as whatever needs bytes of a file
 * that were not read yet may end; "opening" for reading, FILE_NOT_FOUND, PERMISSION_DENIED,
 * NOT_BCC4 and UNSUPPORTED_VERSION; "writing" for IO, NO_SPACE, PERMISSION_DENIED, FILE_NOT_FOUND
 * (no such folder), FILE_EXISTS and WRONG_STATE (another call is writing that path), of streams IO
 * alone.
 *
 * HANDLES are reference counted: create returns one reference, _retain adds one, _release gives one
 * back (NULL is allowed). These two take no const pointer, for they change the count; what a call
 * takes as const may be retained through a cast. Children keep their parents alive. Inputs are
 * copied unless the text says "borrowed". A handle of another kind is INVALID_HANDLE (_retain and
 * _release leave it alone), and so is one of another device: a renderer, its slice and the frames
 * that it draws belong to one.
 *
 * THREADS: different objects may be used from any threads. One object: calls that take it as const
 * may run at the same time; other calls need it alone, and of plans, renderers, scenes and writers
 * get WRONG_STATE where another call is using them, from another thread or around a callback.
 * bccsplat_renderer_cancel and the functions of cancel tokens may come at any time. Results do not
 * depend on the thread count, bit for bit. A child of fork() has none of its parent's threads, but
 * what these had locked: it makes a device and what belongs to it anew.
 *
 * PROGRESS: a bccsplat_progress_fn is called with a fraction that never falls, at most 30 times a
 * second, from any thread but never two at once; a non-zero return cancels: the call ends with
 * CANCELLED. Within it bccsplat_renderer_cancel, every _retain, the functions of cancel tokens and
 * calls on objects of other devices may be made, and within a bccsplat_tile_fn, for which the same
 * holds, bccsplat_frame_get_channel and _copy_part. Others must not: of the renderer or writer at
 * work they are WRONG_STATE, and of its device and volume they may wait for ever for the call that
 * they are in.
 *
 * CANCEL: once a bccsplat_cancel_token is cancelled, calls that look at it end with CANCELLED,
 * those under way soon (some milliseconds), and those that have not begun as soon as they do, until
 * it is reset. A call that takes options looks at options->cancel_token while it lasts, and objects
 * keep the token that they were made with: bccsplat_volume_evaluate and _verify look at the
 * volume's; _prefetch, _get_ranges and bccsplat_slice_create at the volume's and at that
 * of their own options; bccsplat_slice_evaluate, _sample_grid and _get_points at the slice's; calls
 * on a writer that take frames, layers or fields or end it at the writer's; render at that of the
 * render options. Objects stay as good as before (but for writers, see there), arrays and frames
 * keep what was done.
 *
 * PROCESS: the library prints nothing, installs no signal handler, starts no process, keeps the
 * locale as it is, and has no state outside its objects but the error text of each thread. It may
 * be unloaded when the last object is released. It computes in a floating-point environment of its
 * own (round to nearest, no traps, gradual underflow), also while it calls back: a host's rounding
 * mode, traps and flags neither matter nor change.
 */
#ifndef BCCSPLAT_H
#define BCCSPLAT_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#if defined(BCCSPLAT_BUILDING)
#define BCCSPLAT_API __declspec(dllexport)
#else
#define BCCSPLAT_API __declspec(dllimport)
#endif
#elif defined(BCCSPLAT_BUILDING)
#define BCCSPLAT_API __attribute__((visibility("default")))
#else
#define BCCSPLAT_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Status ---- */

typedef int32_t bccsplat_status;

enum {
  BCCSPLAT_OK = 0,
  /* The caller's doing. */
  BCCSPLAT_ERROR_INVALID_ARGUMENT = 1,
  BCCSPLAT_ERROR_INVALID_STRUCT_SIZE = 2,
  /* A handle of another device or kind. */
  BCCSPLAT_ERROR_INVALID_HANDLE = 3,
  /* A call out of order, such as rendering without a slice. */
  BCCSPLAT_ERROR_WRONG_STATE = 4,
  /* A time or point where the field is not defined. */
  BCCSPLAT_ERROR_OUT_OF_DOMAIN = 5,
  BCCSPLAT_ERROR_UNSUPPORTED = 6,
  /* Unknown kernel, channel or attribute. */
  BCCSPLAT_ERROR_NOT_FOUND = 7,
  /* The data's. */
  BCCSPLAT_ERROR_NOT_BCC4 = 16,
  BCCSPLAT_ERROR_UNSUPPORTED_VERSION = 17,
  BCCSPLAT_ERROR_CORRUPT = 18,
  BCCSPLAT_ERROR_TRUNCATED = 19,
  BCCSPLAT_ERROR_CHECKSUM_MISMATCH = 20,
  BCCSPLAT_ERROR_LIMIT_EXCEEDED = 21,
  BCCSPLAT_ERROR_NONFINITE_VALUE = 22,
  BCCSPLAT_ERROR_BOUND_NOT_MET = 23,
  /* Missing data where a value was asked for. */
  BCCSPLAT_ERROR_HOLE = 24,
  /* The environment's. */
  BCCSPLAT_ERROR_OUT_OF_MEMORY = 32,
  BCCSPLAT_ERROR_IO = 33,
  BCCSPLAT_ERROR_FILE_NOT_FOUND = 34,
  BCCSPLAT_ERROR_NO_SPACE = 35,
  BCCSPLAT_ERROR_PERMISSION_DENIED = 36,
  BCCSPLAT_ERROR_FILE_EXISTS = 37,
  BCCSPLAT_ERROR_MEMORY_BUDGET = 38,
  /* The library was built without it; bccsplat_build_info() lists the parts that are in. */
  BCCSPLAT_ERROR_MISSING_FEATURE = 39,
  /* Bytes of a stream are not there yet: bccsplat_last_lacking. */
  BCCSPLAT_ERROR_WOULD_BLOCK = 40,
  BCCSPLAT_CANCELLED = 48,
  BCCSPLAT_ERROR_INTERNAL = 64
};

/* ---- Library ---- */

#define BCCSPLAT_VERSION_MAJOR 0
#define BCCSPLAT_VERSION_MINOR 1
#define BCCSPLAT_VERSION_PATCH 0
/* Rises when a program built against an older header would break. */
#define BCCSPLAT_ABI_VERSION 0

/* A cleared struct with its size set: bccsplat_view view = BCCSPLAT_INIT(bccsplat_view); */
#ifndef __cplusplus
#define BCCSPLAT_INIT(type)                                                                        \
  { .struct_size = sizeof(type) }
#endif

/* Version of the library at run time, major*10000 + minor*100 + patch. */
BCCSPLAT_API int32_t bccsplat_version(void);
/* BCCSPLAT_ABI_VERSION of the library at run time. */
BCCSPLAT_API int32_t bccsplat_abi_version(void);
/* "key=value" pairs separated by "; ": version, compiler, and which optional parts are in (image,
 * simd targets). */
BCCSPLAT_API const char* bccsplat_build_info(void);
/* "BCCSPLAT_ERROR_IO" and the like; "BCCSPLAT_UNKNOWN_STATUS" for other numbers. Never NULL. */
BCCSPLAT_API const char* bccsplat_status_name(bccsplat_status status);
/* Text of the last failed call of this thread: what failed, where, what to try. Empty before the
 * first failure; a successful call leaves it. Valid until the next failing call of this thread.
 * Never NULL. */
BCCSPLAT_API const char* bccsplat_last_error(void);
/* Byte ranges that the last call of this thread lacked which ended with WOULD_BLOCK, in its stream,
 * sorted, not touching each other; for a join, in the first part that lacked some. Writes the
 * first min(capacity, count) pairs of offset and size; ranges: 2 x capacity integers, may be NULL
 * when capacity is 0. count (may be NULL) gets how many are known: at most 256, further ones come
 * to light when the call is made again. 0 before such a call. */
BCCSPLAT_API bccsplat_status bccsplat_last_lacking(
    uint64_t* ranges, uint64_t capacity, uint64_t* count);
/* Names of the reconstruction kernels, index 0 .. ; NULL past the last. "default" comes first. */
BCCSPLAT_API const char* bccsplat_kernel_name(uint32_t index);

/* Returns non-zero to cancel. fraction is in [0, 1]. */
typedef int32_t (*bccsplat_progress_fn)(void* user, double fraction);

/* ---- Cancel token ---- */

/* A wish to stop, given to any number of calls and objects of any devices in the last field of
 * their options. They retain it. */
typedef struct bccsplat_cancel_token bccsplat_cancel_token;

BCCSPLAT_API bccsplat_status bccsplat_cancel_token_create(bccsplat_cancel_token** token);
BCCSPLAT_API void bccsplat_cancel_token_retain(bccsplat_cancel_token* token);
BCCSPLAT_API void bccsplat_cancel_token_release(bccsplat_cancel_token* token);
/* Cancels the token until it is reset. May also be called from a signal handler. */
BCCSPLAT_API bccsplat_status bccsplat_cancel_token_cancel(bccsplat_cancel_token* token);
/* For calls that begin from now on; those that were under way when it was cancelled end all the
 * same. */
BCCSPLAT_API bccsplat_status bccsplat_cancel_token_reset(bccsplat_cancel_token* token);
/* 1: it is cancelled. */
BCCSPLAT_API bccsplat_status bccsplat_cancel_token_is_cancelled(
    const bccsplat_cancel_token* token, int32_t* cancelled);

/* ---- Device: threads, memory, log ---- */

typedef struct bccsplat_device bccsplat_device;

typedef int32_t bccsplat_log_level;
enum { BCCSPLAT_LOG_WARNING = 1, BCCSPLAT_LOG_INFO = 2 };

/* Called from any thread, never two at once per device. Warnings tell of damage and of numbers that
 * lose something; infos what was chosen (the caches of a volume, another level for pictures), a
 * line each time it changes, and once for each volume that layers are read or made again for want
 * of memory, with the cache_bytes that keeps them while the series plays. */
typedef void (*bccsplat_log_fn)(void* user, bccsplat_log_level level, const char* message);

/* A host's own task system: run body(task, i) once for each i in [0, count), in any order and on
 * any threads, and return when all have returned; a runner that leaves some out ends the call
 * that it ran for with WRONG_STATE. body never throws. Calls may nest. Files and streams are read
 * inside these tasks: a body may wait for a disk or a network, with as many reads in flight as
 * the host runs bodies at a time unless max_reads says fewer. */
typedef void (*bccsplat_task_fn)(void* task, uint64_t index);
typedef void (*bccsplat_runner_fn)(void* user, uint64_t count, bccsplat_task_fn body, void* task);

/* The device that draws pictures. The GPU's pictures agree with the CPU's to 45 dB or better;
 * bccsplat_gpu_info says which it draws. */
typedef int32_t bccsplat_backend;
enum {
  /* In render options: the device's backend. In device options: AUTO. */
  BCCSPLAT_BACKEND_DEFAULT = 0,
  /* A graphics card where there is one and it draws the picture, else the CPU; the same for all
   * pictures of a kind, so that none jumps while a camera moves. If the GPU fails, the log says so
   * and the CPU draws. Rasterisers of OpenGL on the CPU are no card. */
  BCCSPLAT_BACKEND_AUTO = 1,
  BCCSPLAT_BACKEND_CPU = 2,
  /* The GPU, a rasteriser on the CPU if there is no card: MISSING_FEATURE where there is neither or
   * it fails, UNSUPPORTED where it does not draw such a picture; the last error says why. */
  BCCSPLAT_BACKEND_GPU = 3
};

typedef struct bccsplat_device_options {
  uint32_t struct_size;
  /* Threads used, the caller's included, up to 4096; 0: as many as the machine has; with a runner:
   * how many it has. */
  int32_t thread_count;
  /* Bytes this device's objects may hold for data at a time; 0: no limit. What writing and slicing
   * hold grows with the voxels of a frame (tests/bench/notes/import.md, moments.md). */
  uint64_t memory_budget;
  /* Warnings, infos and what verify finds; NULL: silent. */
  bccsplat_log_fn log;
  void* log_user;
  /* NULL: a pool of the device's own, joined at its last release. */
  bccsplat_runner_fn runner;
  void* runner_user;
  /* A file that declares more lattice sites is refused (LIMIT_EXCEEDED); 0: 2^42. */
  uint64_t max_sites;
  /* Reads of volumes' files and streams in flight at a time, those of all volumes of the device
   * together; others wait for their turn; 0: as many as there are tasks at work. */
  uint32_t max_reads;
  /* 0 */
  uint32_t reserved;
  /* For all pictures whose render options do not choose another one. */
  bccsplat_backend backend;
  /* 0 */
  uint32_t reserved2;
  /* Bytes of volumes that this device's objects may hold on the GPU at a time; 0: what it has. A
   * picture that needs more is drawn by the CPU, or with BACKEND_GPU refused. */
  uint64_t gpu_memory;
} bccsplat_device_options;

typedef struct bccsplat_device_info {
  uint32_t struct_size;
  int32_t thread_count;
  uint64_t memory_budget; /* bytes; UINT64_MAX: no limit */
  uint64_t memory_used;   /* bytes held now */
  uint64_t memory_peak;   /* bytes held at most so far */
} bccsplat_device_info;

/* options may be NULL. */
BCCSPLAT_API bccsplat_status bccsplat_device_create(
    const bccsplat_device_options* options, bccsplat_device** device);
BCCSPLAT_API void bccsplat_device_retain(bccsplat_device* device);
BCCSPLAT_API void bccsplat_device_release(bccsplat_device* device);
BCCSPLAT_API bccsplat_status bccsplat_device_get_info(
    const bccsplat_device* device, bccsplat_device_info* info);

/* The GPU that a device's pictures may be drawn by, through OpenGL 3.3 or later and EGL, without a
 * window, on a thread of the device's own: whatever OpenGL context a host's threads have stays as
 * it is. It draws slices in every mode, with all planes of a frame, clips, a host's depths and any
 * view; trails as well, and in MODE_COMPOSITE several instances together. src/README.md ("Drawers")
 * has a table of what it leaves to the CPU, such as deep frames and shadows. */
typedef struct bccsplat_gpu_info {
  uint32_t struct_size;
  /* 1: a rasteriser on the CPU, which AUTO does not take. */
  int32_t software;
  /* 1: compute shaders, OpenGL 4.3; 0: fragment shaders. */
  int32_t compute;
  /* 0 */
  uint32_t reserved;
  /* Bytes; 0: its driver does not tell. */
  uint64_t memory;
  /* Bytes of slices that this device's objects hold there now. */
  uint64_t memory_used;
  /* As OpenGL names them; until the device's last release. */
  const char* vendor;
  const char* renderer;
  const char* version;
} bccsplat_gpu_info;

/* Opens the GPU unless a picture has already done so. Also: MISSING_FEATURE when there is no GPU or
 * the library was built without; the last error names the missing part. */
BCCSPLAT_API bccsplat_status bccsplat_device_get_gpu_info(
    bccsplat_device* device, bccsplat_gpu_info* info);

/* ---- Streams of the host ---- */

/* Value that a bccsplat_read_at_fn may return instead of a number of bytes. */
enum {
  BCCSPLAT_READ_WOULD_BLOCK = -65536 /* not there yet; `buffer` may hold anything */
};

/* Reads `size` bytes at `offset` into `buffer`; returns the number read, negative on failure, as
 * more than `size` is; fewer mean that the stream ends there (TRUNCATED). Called from any thread,
 * several at once. A stream whose bytes are on their way answers READ_WOULD_BLOCK. The call that
 * needs them then asks for everything else that it is about to read and knows the place of, so that
 * the host learns of all of it, and ends with WOULD_BLOCK; bccsplat_last_lacking lists the ranges
 * it did not get. Tables are read first: a time slice asks for index pages and tables of
 * corrections, then for chunks, masks and corrections together, a trail for those of all its
 * stills; a slice off the time axis asks for corrections when its chunks are there. Nothing is
 * harmed: bytes that were read stay in the caches, volumes, slices and frames are as before, also
 * with salvage, and no damage is reported. Made again when the bytes are there the call gives what
 * it would have given at once, bit for bit. Opening may end so as well, and is begun anew; a join
 * starts its output over. */
typedef int64_t (*bccsplat_read_at_fn)(void* user, uint64_t offset, void* buffer, uint64_t size);
/* Writes all `size` bytes at `offset`; returns the number written; fewer, or a negative number, are
 * a failure (IO). Never two calls at once, from any thread. Bytes mostly follow each other; some
 * that were written, heads and tables, are written again. */
typedef int64_t (*bccsplat_write_at_fn)(
    void* user, uint64_t offset, const void* buffer, uint64_t size);
/* All that was written so far is to be durable, and seen by readers, before anything that is
 * written from now on. Returns non-zero on failure (IO). */
typedef int32_t (*bccsplat_flush_fn)(void* user);

typedef struct bccsplat_read_stream {
  uint32_t struct_size;
  uint32_t reserved; /* 0 */
  uint64_t size;     /* bytes in all, up to 2^63 - 1 */
  bccsplat_read_at_fn read_at;
  void* user;
  /* Bytes that nobody wants and that are read along where they lie between two wanted ones, to have
   * one read of both: large where a read costs time, as over a network; 0: 4096. A read of chunks
   * takes at most 262144 bytes, or 16 such gaps where that is more. */
  uint64_t merge_gap;
} bccsplat_read_stream;

typedef struct bccsplat_write_stream {
  uint32_t struct_size;
  uint32_t reserved; /* 0 */
  bccsplat_write_at_fn write_at;
  void* user;
  /* Called before and after the bytes that turn those written so far into a file: at the end, and
   * where bccsplat_writer_options.live shows a file under way. NULL: nothing to do. */
  bccsplat_flush_fn flush;
} bccsplat_write_stream;

/* ---- Writer: frames or lattice samples in, .bcc4 out ---- */

/* Failures. A call that is refused for its arguments (INVALID_ARGUMENT, INVALID_STRUCT_SIZE,
 * NOT_FOUND, UNSUPPORTED), for its place in the order of calls (WRONG_STATE: a frame too many, a
 * layer out of turn, finish too early) or for its values (NONFINITE_VALUE, LIMIT_EXCEEDED) leaves
 * the writer as it was: the host goes on as if the call had not been made, and the file is the same
 * byte for byte. A writer ends when something fails while it works: files and streams, memory
 * (OUT_OF_MEMORY, MEMORY_BUDGET), a bound that is missed (BOUND_NOT_MET), a callback that gives up
 * (CANCELLED), a field function that gives a value that is refused, and a file or journal to go on
 * with that turns out not to fit. It can then only be released; every other call is WRONG_STATE and
 * says that an earlier one failed. A cancel token ends a writer in the midst of a call; one that
 * was cancelled before refuses the call, and the writer stays as it was. */
typedef struct bccsplat_writer bccsplat_writer;

/* Types of source values and of stored samples. */
typedef int32_t bccsplat_type;
enum {
  BCCSPLAT_TYPE_DEFAULT = 0,
  BCCSPLAT_TYPE_U8 = 1,
  BCCSPLAT_TYPE_U16 = 2,
  BCCSPLAT_TYPE_F16 = 3,
  BCCSPLAT_TYPE_F32 = 4,
  BCCSPLAT_TYPE_I16 = 5, /* sources only, as all below: stored as u16 with an offset, exactly */
  BCCSPLAT_TYPE_I32 = 6, /* stored as f32 */
  BCCSPLAT_TYPE_F64 = 7, /* stored as f32 */
  BCCSPLAT_TYPE_I8 = 8,  /* stored as u8 with an offset, exactly */
  BCCSPLAT_TYPE_U32 = 9  /* stored as f32 */
};

typedef int32_t bccsplat_lattice;
enum {
  BCCSPLAT_LATTICE_DEFAULT = 0,
  BCCSPLAT_LATTICE_D4STAR = 1,
  BCCSPLAT_LATTICE_BCC = 2,
  BCCSPLAT_LATTICE_CC = 3
};

/* SAMPLES: as the lattice has them. WAVELETS: samples as wavelet coefficients, rounded as far as an
 * error allows: a fraction of the bytes, and a moment reads and decodes all layers of a slab.
 * Stored as U8 or U16; on LATTICE_CC, where the error is half a step between these or more, samples
 * are read as what the coefficients add up to, not as whole steps. Needs dims[3] > 0, and
 * abs_error, or psnr and SET_RANGE, or wavelet_errors (INVALID_ARGUMENT). PARTIAL_APPEND keeps the
 * errors of the file, and refuses smaller ones. */
typedef int32_t bccsplat_store;
enum { BCCSPLAT_STORE_DEFAULT = 0, BCCSPLAT_STORE_SAMPLES = 1, BCCSPLAT_STORE_WAVELETS = 3 };

/* Treatment of NaN and infinity in the source. Doubles above the range of a float (3.4e38) count as
 * infinities. */
typedef int32_t bccsplat_nonfinite;
enum {
  BCCSPLAT_NONFINITE_DEFAULT = 0,
  /* NONFINITE_VALUE, with frame and voxel in the text. */
  BCCSPLAT_NONFINITE_ERROR = 1,
  /* Missing data: never drawn, HOLE when evaluated. Frames keep it at the resolution of the source:
   * a point is missing when the source sample nearest to it is (along each axis, and in time, the
   * later one of two at equal distance).
   * Layers keep it at the resolution of the lattice: a point is missing when the nearest site is.
   * Missing samples are filled smoothly before the filters run, frames without a value by what lies
   * between those beside them (not with fixed_predictions). */
  BCCSPLAT_NONFINITE_HOLE = 2,
  /* NaN becomes air, infinities the largest finite value of the channel's range. */
  BCCSPLAT_NONFINITE_CLAMP = 3
};

/* Frames that are reconstructed while writing and compared with the source; it needs frames (or a
 * field, bccsplat_writer_add_field) and dims[3] > 0 (INVALID_ARGUMENT). */
typedef int32_t bccsplat_measure;
enum {
  /* All with a bound, else none. */
  BCCSPLAT_MEASURE_DEFAULT = 0,
  /* At most 3, evenly spread, where dims[3] is known. Large frames are represented by some boxes:
   * counts and the largest difference are those of the boxes. None when the memory budget does not
   * allow it. */
  BCCSPLAT_MEASURE_SOME = 1,
  BCCSPLAT_MEASURE_ALL = 2
};

/* How a series of frames goes on beyond its first and last one, for the sake of filters and
 * kernels. */
typedef int32_t bccsplat_ends;
enum {
  BCCSPLAT_ENDS_DEFAULT = 0,
  /* As the frames next to the end predict, no bolder than these bear out: what moves is nearly as
   * accurate there as elsewhere. The file has two more layers at each end. Layers and fields given
   * by the host have four there, with the host's own values: it is asked for frames below 0 and
   * beyond the last. dims[3] may be unknown. */
  BCCSPLAT_ENDS_PREDICT = 1,
  /* As its mirror image: no more layers; the first and last three or four frames are less accurate
   * where anything moves. */
  BCCSPLAT_ENDS_MIRROR = 2,
  /* The last frame leads to the first, as of heart beats and climatologies: the frame behind the
   * last one is frame 0 again, and no frame is less accurate than others. It follows the last after
   * the mean distance of frames, however uneven they are. Also for layers and fields. Needs dims[3]
   * of at least 2; UNSUPPORTED in parts, live, short or with PARTIAL_APPEND. */
  BCCSPLAT_ENDS_PERIODIC = 3
};

/* How a field goes on beyond its faces, the first and last sample along x, y and z, for the sake of
 * filters and kernels. */
typedef int32_t bccsplat_faces;
enum {
  BCCSPLAT_FACES_DEFAULT = 0,
  /* As the samples next to the face predict: the file has two more planes of the lattice outside
   * each face, except along axes of which they would be more than a fifth. Layers and fields given
   * by the host have four there, with the host's own values: bccsplat_layer_geometry begins
   * outside. */
  BCCSPLAT_FACES_PREDICT = 1,
  /* As its mirror image: no more planes; within three samples of a face the field is less accurate
   * where it is not level there. */
  BCCSPLAT_FACES_MIRROR = 2,
  /* PREDICT across these axes alone, at any cost; the sum for two or three; INVALID_ARGUMENT for a
   * periodic axis, which has no faces. */
  BCCSPLAT_FACES_PREDICT_X = 4,
  BCCSPLAT_FACES_PREDICT_Y = 8,
  BCCSPLAT_FACES_PREDICT_Z = 16
};

/* Axes of space that are periodic, as longitude is: the sum for two or three. Behind the last
 * sample comes the first one again, as far from it as samples are from each other; there are no
 * faces, nothing is predicted or mirrored, and the volume reaches to index dims[axis], which is
 * sample 0. Also for layers and fields. Needs two samples at least. */
enum { BCCSPLAT_PERIODIC_X = 1, BCCSPLAT_PERIODIC_Y = 2, BCCSPLAT_PERIODIC_Z = 4 };

/* Bits of bccsplat_channel_options.set_mask. LABELS: values are labels, which nothing lies between,
 * of any number and type, whole numbers up to 2^24: every point has that of the nearest sample
 * (bccsplat_volume_evaluate). They need lattice CC at distance 1 and their own codes, without
 * levels, as they have no means: STORE_WAVELETS, other lattices and distances, levels, SET_RANGE of
 * integers without value_step, and F16 of other types are refused (UNSUPPORTED). QUANTITIES: they
 * are none, however few they are. Without either, readers take up to 32 whole numbers within 255 of
 * an integer source for labels. Both: INVALID_ARGUMENT. The file says it as the attribute "labels."
 * and the channel's name: "yes" or "no". */
enum {
  BCCSPLAT_CHANNEL_SET_AIR = 1,
  BCCSPLAT_CHANNEL_SET_RANGE = 2,
  BCCSPLAT_CHANNEL_LABELS = 4,
  BCCSPLAT_CHANNEL_QUANTITIES = 8
};

/* Fate of a file that is not finished: `path`.partial and its journal, `path`.journal. */
typedef int32_t bccsplat_partial;
enum {
  /* Removed at the last release; a crash may leave the first of them. */
  BCCSPLAT_PARTIAL_DEFAULT = 0,
  /* Both stay after a failure, a release without finish, or a crash (which may cost the last second
   * of work). Only RESUME continues such a pair: every other writer of `path` begins anew and
   * removes it. */
  BCCSPLAT_PARTIAL_KEEP = 1,
  /* As KEEP, and continues such a pair without coding its contents again. The host adds everything
   * from the start, with the same options, attributes and sources (WRONG_STATE otherwise, and the
   * pair stays as it is: for options at create, with the name of the first that differs, for
   * attributes, sources and types that follow from the first boxes when the first slab is there)
   * and the same samples. These are not compared, but placeholders will not do: the last slabs are
   * made of them, and where bytes come to lie elsewhere the call ends with WRONG_STATE and the pair
   * stays as it is. The file is the same byte for byte as one written undisturbed. The two files
   * are checked against each other: from the first place where they do not fit, or end, everything
   * is written anew. */
  BCCSPLAT_PARTIAL_RESUME = 2,
  /* `path` is a finished file whose series goes on; it is replaced at finish, and stays as it is
   * until then. WRONG_STATE at create, with the file and what differs, when it is a part or
   * unfinished, or lattice, affine, store or channels (number, names, air, air_threshold, coding,
   * error of wavelets) are others, or units or labels that both tell; the coding of a channel
   * without source_type is compared when the first slab is there. What the new frames do not touch
   * is copied, not coded again. Without options->part the host adds all frames, the old ones first.
   * With it (first: the number of frames of the file, end: dims[3]) it adds those of
   * get_part_frames, the new ones and up to some twenty before them, and non-finite values and
   * coding errors are reported for these alone; not for bounds, MEASURE_ALL or files of layers
   * (WRONG_STATE). Either way the file is the same byte for byte as one written in one go with the
   * same ENDS, but that channels may only be rounded as they were, and that with part the errors of
   * levels (relative_rmse) stay those measured at frames of the file before. */
  BCCSPLAT_PARTIAL_APPEND = 3
};

typedef struct bccsplat_channel_options {
  uint32_t struct_size;
  uint32_t set_mask;
  /* Unique in the file, such as "density", UTF-8 (INVALID_ARGUMENT); NULL: "value". */
  const char* name;
  /* Unit of the values; NULL: unknown. */
  const char* unit;
  /* Precision of the source values; DEFAULT: the type of the first box for the channel that gets
   * the first frame, F32 for others and for layers. */
  bccsplat_type source_type;
  /* U8, U16, F16 or F32 on disk; DEFAULT: the source's own precision. */
  bccsplat_type value_type;
  /* Value of sites that are not stored. Without SET_AIR it is 0, as in a cleared struct, whatever
   * the data: where 0 is a value like others and another one means empty, as -1024 of CT, set it.
   * The file has the nearest float of air. Samples that equal air as it was given count as air,
   * also doubles of 273.15.
   *
   * The base of a field is what the sum over its sites is added to: usually air. Values come back
   * within the kernel's ripple, a small share of their distance from the base, and a constant that
   * is the base comes back as it was. Readers take the median of the samples for the base of a
   * dense field far from its air. Dense: at most a sixteenth of the sites is not stored. Far: air
   * is further from all samples than these are from each other, or eight times as far from nine
   * tenths of them. The base stays air where abs_error meets parts or fixed_predictions. Other
   * files with abs_error tell such a base, and readers that do not know of it refuse them.
   *
   * Floats, and integers of 32 bits, are stored as floats relative to air, far from it in coarse
   * steps. finish warns (the device's log) of dense values whose distance from air is more than 8
   * times their range: where they ripple, and where steps are more than 1/256 of the range. */
  double air;
  /* A site within this of air is not stored; 0: sites that equal air in the stored type, and for
   * floats the filter's ringing beside air, up to 1/512 of the values nearby, are not stored. */
  double air_threshold;
  /* SET_RANGE: smallest and largest value, spread over the codes of U8 or U16; needed when floats
   * are stored as U8 or U16; values outside are clamped and counted. */
  double range[2];
  /* U8 and U16 with SET_RANGE: value from code to code, such that air has a code of its own; the
   * codes must hold the range (INVALID_ARGUMENT); 0: the range over all codes. */
  double value_step;
} bccsplat_channel_options;

/* One of several files written by processes of their own, on any machines and in any order, that
 * bccsplat_join_parts makes one. All parts are written with the same options, attributes and
 * sources; each holds the layers between its frames and is a .bcc4 file by itself, air elsewhere.
 * Frames only (layers and fields are UNSUPPORTED); with NONFINITE_CLAMP every channel needs
 * SET_RANGE.
 * A part may be a block of space as well: it holds the bricks that begin within its samples, made
 * of these and of a few around (bccsplat_writer_get_part_box). One frame may be divided so, too.
 * Every channel then needs source_type, and planes outside or layers beyond the ends (FACES_ and
 * ENDS_PREDICT, or by DEFAULT), levels and NONFINITE_HOLE need fixed_predictions. abs_error is
 * kept, and psnr and MEASURE_ALL measured, at the samples of each block, which then takes a few
 * more around them. What depends on more of a frame than its surroundings is UNSUPPORTED, and the
 * text says what to do instead: STORE_WAVELETS, lowpass, MEASURE_SOME, periodic axes. */
typedef struct bccsplat_series_part {
  uint32_t struct_size;
  /* 0 */
  uint32_t reserved;
  /* Its frames: first .. end-1 of the series. */
  uint64_t first;
  uint64_t end;
  /* Frames given before the first one needed: those back to one that is not missing altogether (no
   * finite value in some channel), or back to frame 0; 0: none. */
  uint64_t lead;
  /* Times of all frames of the series, dims[3] of them, rising; borrowed during the call. */
  const double* times;
  /* Its samples along x, y and z: box_begin .. box_end-1, within dims; all 0: all of space. Blocks
   * of one series divide its samples in any way, blocks of other frames in another one. */
  uint64_t box_begin[3];
  uint64_t box_end[3];
} bccsplat_series_part;

/* Flags of an axis. */
enum {
  BCCSPLAT_AXIS_DOWN = 1 /* coordinates count against the axis of the world, as depths do */
};

/* Where the samples stand along an axis of space. */
typedef struct bccsplat_axis {
  uint32_t struct_size;
  uint32_t flags; /* BCCSPLAT_AXIS_... */
  /* 0: evenly spaced, as the affine says; else as many as there are samples, at least 2. */
  uint64_t count;
  /* `count` of them, finite, rising throughout or falling throughout; NULL where there is none. */
  const double* coordinates;
  /* Unit of the coordinates; NULL or "": unknown. */
  const char* unit;
} bccsplat_axis;

typedef struct bccsplat_writer_options {
  uint32_t struct_size;
  /* None defined; 0. */
  uint32_t set_mask;
  /* Source samples per axis; dims[3] = 0: as many frames as are given, of which nothing is
   * measured: where that is wanted, the most that may come, and bccsplat_writer_finish_short.
   * Frames are one unit of time apart whatever their times are. A gap of more than three usual
   * steps whose frames were not measured is a warning of the device's log at finish: values near it
   * may be far off. */
  uint32_t dims[4];
  /* DEFAULT: D4* for a series, BCC for one frame. */
  bccsplat_lattice lattice;
  /* Cartesian frames -> lattice sites. */
  bccsplat_store store;
  bccsplat_nonfinite nonfinite;
  /* Non-zero: replace an existing file at finish. */
  int32_t overwrite;
  /* Non-zero: what lies outside faces and beyond ends is predicted with the same boldness for all
   * data, else with what does best next to each (FACES_PREDICT, ENDS_PREDICT). Parts that are
   * blocks of space know too little for a choice; a file that is to be the same byte for byte has
   * it, too. Frames of coarser levels then are filtered as they are, to some units in the last
   * place of a float, else as their difference from their least value where all are of one sign and
   * within a factor of two; their errors are not measured. With abs_error air is the base of the
   * field (air). With NONFINITE_HOLE data are continued over missing samples for a few distances of
   * the coarsest level, behind which these are air; a frame without a finite value is refused
   * (NONFINITE_VALUE; of blocks by bccsplat_join_parts). 0: chosen. */
  int32_t fixed_predictions;
  /* 0: one channel with default options. */
  uint32_t channel_count;
  const bccsplat_channel_options* channels;
  /* Index space -> world, row-major; all zero: identity. The mean voxel is at least 1e-30 long.
   * With `axes` it is of even positions: for a world that has the coordinates an axis begins at
   * the first one and is (last - first) / (n - 1) per position long. */
  double affine[16];
  /* "mm", ...; NULL: unknown. */
  const char* spatial_unit;
  /* "s", ...; NULL: unknown. */
  const char* time_unit;
  /* Lattice distance in source samples, up to 65536; 0: 1. */
  double scale;
  /* The same along time, in frames; 0: 1. */
  double time_scale;
  /* Kernel of readers; NULL: default, for CC of samples at 1 "exact": the samples as far as type
   * and 32-bit floats hold them. */
  const char* recommended_kernel;
  /* NULL: none; fraction of the frames (or layers), only when dims[3] is known. */
  bccsplat_progress_fn progress;
  void* progress_user;
  /* > 0: no finite source sample of any channel, reconstructed with the recommended kernel, is
   * further off than this: each is checked, and those that miss are stored as corrections, which
   * every way of looking sees (bccsplat_slice_options). Needs dims[3] > 0 (INVALID_ARGUMENT).
   * BOUND_NOT_MET where floats cannot hold it; 0: no bound. */
  double abs_error;
  /* > 0: in dB over all samples of a channel, peak: the range of its source; checked on every
   * frame, BOUND_NOT_MET at finish when it is missed; up to 1000; needs dims[3] > 0
   * (INVALID_ARGUMENT); 0: no bound. */
  double psnr;
  /* Which frames to compare with the source. */
  bccsplat_measure measure;
  /* Fate of unfinished work; files only. */
  bccsplat_partial partial;
  /* Non-zero: frames lose what D4* (one frame: BCC) cannot hold before they are resampled: the
   * frequencies with |f_i| + |f_j| > sqrt2 for some pair of axes, f in units of the Nyquist
   * frequency of a grid of the lattice distance. Otherwise they fold back; little of natural data
   * lies there, half the energy of white noise does. Ends are mirrored; constants stay exact; at
   * scale 1, 30 frames to either side take part (scale and time_scale widen this), held as floats
   * within the memory budget. INVALID_ARGUMENT for CC; layers and fields are taken as they are; 0:
   * none. */
  int32_t lowpass;
  /* Number of coarser levels, 0 to 15. Level l is the same series at 2^l times the distance in
   * space, for small pictures (bccsplat_slice_options.level). Made of frames only: with layers and
   * fields UNSUPPORTED. Bounds and corrections belong to level 0. PARTIAL_APPEND keeps the levels
   * of the file. With `measure`, but without fixed_predictions, their errors are reported as well
   * (relative_rmse). */
  uint32_t levels;
  /* NULL: the whole series; PARTIAL_APPEND: see there; else dims[3] is the number of frames of the
   * series, and those of bccsplat_writer_get_part_frames are added. */
  const bccsplat_series_part* part;
  /* BCCSPLAT_ENDS_...; DEFAULT: PREDICT for D4* of at least 20 layers, to which the ends add a
   * fifth at most (14 frames at time_scale 1; dims[3] known), else MIRROR; for layers and fields
   * MIRROR. */
  bccsplat_ends ends;
  /* BCCSPLAT_FACES_...; DEFAULT: for frames PREDICT along axes of which the planes outside are a
   * sixteenth at most (43 samples at scale 1), unless the sites are the source samples in space (CC
   * at distance 1); else, and for layers and fields, MIRROR. */
  bccsplat_faces faces;
  /* Lattice distance along x, y, z in source samples, and along t in frames, each up to 65536; 0:
   * scale, along t time_scale. In space it is made a little smaller, so that a whole number of
   * planes ends on the last sample; in time only with ENDS_PERIODIC, so that a whole number of
   * layers makes a turn. */
  double scales[4];
  /* > 0: after every so many slabs (of 8 layers) that all channels have, the file under way,
   * `path`.partial, is made to be opened as it stands, durable, for a live view and against
   * crashes: bccsplat_volume_info.series_state; bccsplat_volume_reopen follows it. Until the first
   * of them can be seen (a dozen frames or so, of a short series or with `lowpass` only at the end)
   * it is NOT_BCC4. Its frames are those of which all layers are there that the kernel
   * of the file reaches: at the same moments they are what the finished file has (where air is far
   * from a field without air, but for the last digits). With other kernels the last ones are as
   * accurate as those of ENDS_MIRROR. Without finish the file is removed or kept as `partial` says.
   * With PARTIAL_RESUME it shows what the earlier writer showed until there is more.
   * The finished file has a few more bytes, which nothing refers to. UNSUPPORTED with part; 0: it
   * can be opened when it is finished. */
  uint32_t live;
  /* BCCSPLAT_PERIODIC_..., the sum; 0: none. */
  uint32_t periodic_axes;
  /* NULL: none; create looks at it as well. */
  bccsplat_cancel_token* cancel_token;
  /* NULL: all axes of space are evenly spaced. Else three, x y z, copied. Where one has coordinates
   * the volume's spatial_unit is "", and the one given here is that of axes that name none. Samples
   * and bounds are the same as without them: nothing is resampled. INVALID_ARGUMENT: another count
   * than dims, not monotone; UNSUPPORTED: of a periodic axis. PARTIAL_APPEND refuses others than
   * the file's. Readers that know nothing of coordinates see an evenly spaced volume of the same
   * corners. */
  const bccsplat_axis* axes;
  /* STORE_WAVELETS: for each channel the root mean square error that the sites of every slab may
   * have, air included, in units of its values; NULL, or 0 for a channel: the smaller of the error
   * that psnr allows and 0.42 of the largest error, whose corrections do the rest. */
  const double* wavelet_errors;
  /* For each channel its own abs_error, in units of its values; NULL, or 0 for a channel:
   * abs_error. */
  const double* abs_errors;
} bccsplat_writer_options;

/* A dense box of one frame; samples that no box covers are air. Boxes of a frame must not overlap
 * (INVALID_ARGUMENT, with the numbers of two that do). */
typedef struct bccsplat_box {
  uint32_t struct_size;
  /* Type of the samples, not DEFAULT. */
  bccsplat_type type;
  /* Borrowed during the call; sample (begin[0], begin[1], begin[2]) stands first. */
  const void* data;
  /* Index of the first sample (x, y, z). */
  int64_t begin[3];
  /* Samples per axis; begin + dims <= the writer's dims. */
  int64_t dims[3];
  /* Distance of neighbouring samples per axis, any sign, 0 to repeat one; all zero: packed, x
   * fastest. */
  int64_t stride_bytes[3];
} bccsplat_box;

/* Where the sites of a layer stand, for producers that sample the lattice themselves. Site (i, j,
 * k) of the layer has index-space position origin + step * (i, j, k) and frame number `frame`. In
 * space no site lies outside the samples but on planes asked for (FACES_PREDICT); in time the last
 * layer may lie up to one layer behind the last frame (of 24 frames at 23.33): a producer gives the
 * value of its field there, or else the value at its end. */
typedef struct bccsplat_layer_geometry {
  uint32_t struct_size;
  int32_t coset;       /* 0 or 1 */
  int64_t dims[3];     /* sites per axis */
  double origin[3];    /* index space */
  double step[3];      /* index space */
  double frame;        /* index along t; 0 for a static lattice */
  int64_t layer_count; /* layers of the whole lattice */
} bccsplat_layer_geometry;

typedef struct bccsplat_writer_report {
  uint32_t struct_size;
  /* Slabs of layers taken over by PARTIAL_RESUME or _APPEND, all channels. */
  uint32_t slabs_reused;
  uint64_t frames;
  /* Samples of the Cartesian source, all channels. */
  uint64_t cc_samples;
  /* Samples of the source that are further than air_threshold from air. */
  uint64_t cc_relevant;
  /* Lattice sites, all channels, those outside the faces not counted. */
  uint64_t sites_total;
  /* Lattice sites that are stored. */
  uint64_t sites_kept;
  /* Stored sites that are missing data. */
  uint64_t holes;
  /* Samples outside the range of the stored type (overshoot of the filter included). */
  uint64_t clamped;
  /* Source values that were NaN or infinite. */
  uint64_t nonfinite;
  /* Bytes of the source values in the source's precision. */
  uint64_t bytes_source;
  uint64_t bytes_file;
  /* Part of bytes_file that says which sites are stored. */
  uint64_t bytes_runs;
  /* Their values. */
  uint64_t bytes_values;
  /* Tables and metadata, corrections included. */
  uint64_t bytes_index;
  /* Compared with the source, bccsplat_writer_get_error. */
  uint64_t frames_measured;
  /* Source samples with a correction. */
  uint64_t corrected;
  /* Part of bytes_index that corrections take. */
  uint64_t bytes_corrections;
  /* Largest difference of a stored lattice sample from what the resampling filter made: by
   * rounding, clamping, or as air; over all channels. */
  double coding_max;
  /* The same, over all sites. */
  double coding_rmse;
  /* Lattice sites outside the faces, all channels (BCCSPLAT_FACES_PREDICT). */
  uint64_t sites_outside;
} bccsplat_writer_report;

/* Differences of the file from its source at the source samples: the field reconstructed with the
 * recommended kernel, corrections included, minus the source; finite source samples only. */
typedef struct bccsplat_error_report {
  uint32_t struct_size;
  uint32_t reserved;
  /* The frame; in the report of a series, the frame of the largest difference. */
  uint64_t frame;
  /* Number of samples compared. */
  uint64_t samples;
  double max_abs;
  double rmse;
  /* Range of the channel's source. */
  double peak;
  /* dB, 20 log10(peak / rmse); infinite without any difference, NaN without samples. */
  double psnr;
  /* Samples further than air_threshold from air; the next three are theirs. */
  uint64_t non_air_samples;
  double non_air_max_abs;
  double non_air_rmse;
  double non_air_psnr;
  /* Place of the largest difference, in `frame`. */
  uint64_t voxel[3];
  /* Value of the source there. */
  double expected;
  /* Value of the file there. */
  double got;
  /* Largest difference before corrections. */
  double uncorrected_max_abs;
  /* Samples with a correction. */
  uint64_t corrected;
  /* Samples in holes of the lattice; not compared. */
  uint64_t lost;
} bccsplat_error_report;

/* The field of a host at n points: xyzt, n x 4 doubles, index space; writes n values. Non-zero:
 * give up. Called from the thread that called bccsplat_writer_add_field, one call at a time. */
typedef int32_t (*bccsplat_field_fn)(void* user, uint64_t n, const double* xyzt, float* values);

/* Starts a file. The bytes go to a neighbour of `path`, `path`.partial, that takes the name at
 * finish, so `path` never holds half a file. Also: writing (FILE_EXISTS unless options->overwrite;
 * IO for a folder or a device); NOT_FOUND (kernel); UNSUPPORTED (options that exclude each other);
 * LIMIT_EXCEEDED (a layer of more than 4096^3 sites, mostly not before the first frame); with
 * PARTIAL_RESUME and _APPEND opening, and WRONG_STATE. */
BCCSPLAT_API bccsplat_status bccsplat_writer_create(bccsplat_device* device, const char* path,
    const bccsplat_writer_options* options, bccsplat_writer** writer);
/* The same into a host's stream (copied; its user pointer is borrowed until release): the bytes
 * that a file gets, report.bytes_file of them from offset 0 on. A stream has no name to take over
 * and none to give: `overwrite` has no effect, PARTIAL_... is UNSUPPORTED, and the host discards
 * the bytes of a writer that was not finished. The writer ends with a write that fails. Also: as
 * bccsplat_writer_create. */
BCCSPLAT_API bccsplat_status bccsplat_writer_create_stream(bccsplat_device* device,
    const bccsplat_write_stream* stream, const bccsplat_writer_options* options,
    bccsplat_writer** writer);
/* Adds the next frame of a channel. `time` is in the volume's time unit and rises strictly from
 * frame to frame; every channel of a frame gets the same time. count = 0: the whole frame is air.
 * Memory held does not depend on the number of frames. Also: NOT_FOUND (channel), NONFINITE_VALUE,
 * LIMIT_EXCEEDED (values further than 1e36 from air, labels of I32, U32 or F64 beyond 2^24,
 * more than 2^31 - 1 frames), BOUND_NOT_MET, WRONG_STATE, writing. */
BCCSPLAT_API bccsplat_status bccsplat_writer_add_frame(bccsplat_writer* writer, uint32_t channel,
    double time, const bccsplat_box* boxes, uint64_t count);
/* Returns the frames that a writer takes: begin .. end-1, in order. A part takes the frames that
 * its layers are made of, a few more to either side than its own. A whole series takes 0 .. dims[3]
 * (0: any number). The progress of a part counts these frames. */
BCCSPLAT_API bccsplat_status bccsplat_writer_get_part_frames(
    const bccsplat_writer* writer, uint64_t* begin, uint64_t* end);
/* Returns the samples of each frame that a writer takes, begin[a] .. end[a]-1 along x, y and z:
 * those of a block and around it as many as its bricks are made of, up to cells of 16 x 8 x 8
 * samples; else all. What no box of bccsplat_writer_add_frame covers there is air, and what boxes
 * have elsewhere is not read. begin, end: 3 numbers each. */
BCCSPLAT_API bccsplat_status bccsplat_writer_get_part_box(
    const bccsplat_writer* writer, uint64_t* begin, uint64_t* end);
/* Geometry of a layer, 0 .. layer_count-1, as bccsplat_writer_add_layer takes them; for a part: of
 * all layers of the series, those beyond its ends included. Needs dims[3] > 0. Also: WRONG_STATE
 * (without that), NOT_FOUND (layer). */
BCCSPLAT_API bccsplat_status bccsplat_writer_get_layer_geometry(
    const bccsplat_writer* writer, int64_t layer, bccsplat_layer_geometry* geometry);
/* Adds the next layer of a channel as lattice samples (no resampling): count = product of the
 * layer's dims, x fastest. Layers come in order and a writer takes either frames or layers. The
 * times of the frames are those of bccsplat_writer_set_times. NaN follows options->nonfinite. Also:
 * as bccsplat_writer_add_frame, and UNSUPPORTED (of a part, or with levels); with a bound or
 * measuring, which need source samples, WRONG_STATE. */
BCCSPLAT_API bccsplat_status bccsplat_writer_add_layer(
    bccsplat_writer* writer, uint32_t channel, int64_t layer, const float* samples, uint64_t count);
/* Adds all layers of a channel by asking `field` for its value at each site, at most 65536 points
 * at a time: no source grid, no resampling. Instead of frames and layers; needs dims[3] > 0, which
 * with the other dims states the domain. With a bound or measure, `field` is also asked at the
 * source samples of the frames to compare. NaN follows options->nonfinite. CANCELLED when `field`
 * gave up. Also: as bccsplat_writer_add_layer. */
BCCSPLAT_API bccsplat_status bccsplat_writer_add_field(
    bccsplat_writer* writer, uint32_t channel, bccsplat_field_fn field, void* user);
/* Times of a file written by layers or a field: frame i is at first + i * step, step > 0, of at
 * least 1e-30. Default 0 and 1. Frames have times of their own: WRONG_STATE once some were added;
 * called before, it has no effect on them. Also: WRONG_STATE. */
BCCSPLAT_API bccsplat_status bccsplat_writer_set_times(
    bccsplat_writer* writer, double first, double step);
/* A free attribute of the file; a key given twice keeps the last value. INVALID_ARGUMENT: "labels."
 * and a channel's name, unless its options say the same. LIMIT_EXCEEDED, and nothing is taken,
 * where the texts of all attributes and sources come to more than 32 MiB. Also: WRONG_STATE
 * (finished, or failed). */
BCCSPLAT_API bccsplat_status bccsplat_writer_set_attribute(
    bccsplat_writer* writer, const char* key, const char* value);
/* Records where the data came from: name, size in bytes and CRC-32 (0: unknown). Also:
 * LIMIT_EXCEEDED and WRONG_STATE, as above. */
BCCSPLAT_API bccsplat_status bccsplat_writer_add_source(
    bccsplat_writer* writer, const char* name, uint64_t bytes, uint32_t crc32);
/* Writes all pending data and gives the file its name. report may be NULL. WRONG_STATE while frames
 * or layers are missing, or fewer came than the file of PARTIAL_APPEND has: they may still come, or
 * finish_short ends without new ones. The writer can only be released afterwards. Also:
 * WRONG_STATE, BOUND_NOT_MET, NONFINITE_VALUE, LIMIT_EXCEEDED, writing. */
BCCSPLAT_API bccsplat_status bccsplat_writer_finish(
    bccsplat_writer* writer, bccsplat_writer_report* report);
/* The same for a series that ends sooner than dims[3] said, such as a simulation that is stopped:
 * of as many frames as every channel got, or of the frames that the layers reach. With all frames
 * it is finish. The file is that of a writer that was told this number at the start, byte for byte,
 * with these exceptions: what dims[3] has settled stays so (whether ENDS_DEFAULT predicts, which
 * frames MEASURE_SOME looks at, that one frame under `lowpass` is one of a series); with several
 * channels or levels, or `live`, the chunks may stand in another order, beside tables that live
 * readers were shown; layers that were given beyond the last
 * frame stay; and there are no counts of wavelets, so that PARTIAL_APPEND needs all frames of
 * the file. Also: as finish; WRONG_STATE where channels got more than others, fewer frames than the
 * file of PARTIAL_APPEND has, or one frame alone of which layers in time are made already (of
 * layers; of frames under ENDS_MIRROR, or where ENDS_DEFAULT is that); UNSUPPORTED for periodic
 * series, and for parts that lack frames of theirs. */
BCCSPLAT_API bccsplat_status bccsplat_writer_finish_short(
    bccsplat_writer* writer, bccsplat_writer_report* report);
/* Returns a measured error, after finish: measured = -1 for the series, else 0 .. frames_measured-1
 * for one frame. Also: WRONG_STATE before finish, NOT_FOUND (channel; nothing was measured, or past
 * the last). */
BCCSPLAT_API bccsplat_status bccsplat_writer_get_error(const bccsplat_writer* writer,
    uint32_t channel, int64_t measured, bccsplat_error_report* error);
BCCSPLAT_API void bccsplat_writer_retain(bccsplat_writer* writer);
/* The last release without finish leaves no file. */
BCCSPLAT_API void bccsplat_writer_release(bccsplat_writer* writer);

typedef struct bccsplat_join_options {
  uint32_t struct_size;
  int32_t overwrite;             /* non-zero: replace an existing file */
  bccsplat_progress_fn progress; /* NULL: none; fraction of the bytes */
  void* progress_user;
  bccsplat_cancel_token* cancel_token; /* NULL: none */
  /* Non-zero: coarser levels that no part has measured, as those of blocks, are compared with level
   * 0 in a few boxes of at most three frames, and the file tells their relative_rmse, by which
   * pictures choose a level; some 1 % of the work that writing them was. */
  int32_t compare_levels;
  int32_t reserved; /* 0 */
} bccsplat_join_options;

/* Makes one file of the parts of a series, given in any order; nothing is coded again, and memory
 * does not depend on their size (16 bytes for each run along x of missing samples of a frame that
 * is divided into blocks); some 20 of their files are open at once. The file is the same byte for
 * byte as one written without parts by the same version, each frame's channels added in order, but
 * for compare_levels, and without fixed_predictions for channels with a bound (abs_error, psnr) far
 * from their air: parts do not know each other's values, keep air as base of the field, take more
 * corrections and ripple between samples (see air). INVALID_ARGUMENT, naming the files, frames and
 * samples, when they are not parts of one series, or a frame, or a sample of one, is in none or in
 * two of them; NONFINITE_VALUE when all samples of a frame are missing in its blocks; BOUND_NOT_MET
 * when the series misses the psnr of its options. Also: opening, writing. options and report may be
 * NULL; the report's slabs_reused are those joined. With `overwrite` the output may be one of the
 * inputs, which it replaces at the end. */
BCCSPLAT_API bccsplat_status bccsplat_join_parts(bccsplat_device* device, uint64_t count,
    const char* const* parts, const char* path, const bccsplat_join_options* options,
    bccsplat_writer_report* report);
/* The same from `count` streams of a host into another one, with the same bytes; texts name the
 * parts by their place in `parts`, from 0 on. Also: as above. */
BCCSPLAT_API bccsplat_status bccsplat_join_streams(bccsplat_device* device, uint64_t count,
    const bccsplat_read_stream* parts, const bccsplat_write_stream* stream,
    const bccsplat_join_options* options, bccsplat_writer_report* report);

/* ---- Plan: how a series is best stored ---- */

/* What was chosen for a series by looking at it: lattice, distances, steps, store and levels, so
 * that it loses least, or keeps an error with the fewest bytes. A writer with the options of a plan
 * that gets the same frames writes the bytes of `bcc4 import`, but for attributes and sources. */
typedef struct bccsplat_plan bccsplat_plan;

/* Gives a frame of a channel: writes dims[0] * dims[1] * dims[2] values of the channel's type, x
 * fastest. Non-zero: give up. Called from the thread that called bccsplat_plan_create, one call at
 * a time; frames are asked for in any order, and some more than once. */
typedef int32_t (*bccsplat_source_fn)(void* user, uint64_t frame, uint32_t channel, void* values);

/* Hears that boxes are no longer in use. */
typedef void (*bccsplat_release_fn)(void* keeper);
/* A frame of a channel, or the part of it that was asked for, in the host's memory. */
typedef struct bccsplat_source_boxes {
  uint32_t struct_size;
  uint32_t reserved; /* 0 */
  /* As of bccsplat_writer_add_frame; they and their values stay until `release`. */
  const bccsplat_box* boxes;
  uint64_t count;
  /* NULL: none; called once, from any thread. */
  bccsplat_release_fn release;
  void* keeper;
} bccsplat_source_boxes;
/* Gives the samples begin .. end-1 (x, y, z; 3 numbers each) of a frame of a channel as boxes,
 * without a copy: what no box covers there is air, and what boxes have elsewhere is not looked at.
 * Non-zero: give up. Called as bccsplat_source_fn is. */
typedef int32_t (*bccsplat_boxes_fn)(void* user, uint64_t frame, uint32_t channel,
    const uint64_t* begin, const uint64_t* end, bccsplat_source_boxes* boxes);

/* What a plan needs to know of a channel beside its bccsplat_channel_options. */
typedef struct bccsplat_plan_channel {
  uint32_t struct_size;
  /* Type of the values that `frame` writes, and of the writer's boxes; DEFAULT: F32. */
  bccsplat_type type;
  /* Non-zero: NaN is missing data, so that NONFINITE_DEFAULT is NONFINITE_HOLE. */
  int32_t missing;
  /* BCCSPLAT_CHANNEL_LABELS or _QUANTITIES: what the source says its values are, which the plan
   * follows and may give up, as where density asks for a lattice that blends labels; 0: found by
   * looking. */
  uint32_t kind;
  /* Values are offset + step * integers of the channel's source_type, as of files with a slope; 0:
   * they are the numbers of the source themselves. */
  double step;
  double offset;
  /* Samples that a sparse source sets, frame by frame, wish->dims[3] numbers: large frames with
   * next to none get no levels and no wavelets. NULL: not known. */
  const uint64_t* active;
} bccsplat_plan_channel;

/* Bits of bccsplat_plan_options.set_mask. */
enum {
  BCCSPLAT_PLAN_SET_LEVELS = 1,      /* wish->levels are wanted, 0 among them */
  BCCSPLAT_PLAN_AUTO_TIME_SCALE = 2, /* the distance along time alone is chosen */
  BCCSPLAT_PLAN_EVERYTHING = 4,      /* finds out all that its JSON can tell */
  BCCSPLAT_PLAN_ANY_THREAD = 8,      /* frames are read ahead, by another thread, one at a time */
  BCCSPLAT_PLAN_LARGE_FRAMES = 16    /* frames do not fit the memory: `boxes` gives parts of them */
};

typedef struct bccsplat_plan_options {
  uint32_t struct_size;
  uint32_t set_mask;
  /* What is known and wanted, not NULL: what it says is kept, and what it leaves at its default is
   * chosen. dims are all > 0. Chosen are: lattice with its distances (unless one of scale,
   * time_scale and scales is given), store, faces, ends, value_type with range and value_step,
   * wavelet_errors, levels (from 192^3 on; none for labels; without SET_LEVELS wish->levels say
   * nothing), whether a channel has LABELS or QUANTITIES, air of channels of floats without SET_AIR
   * that are hardly ever 0, and `measure`, which is SOME. abs_error or psnr is the bound that the
   * smallest file is to keep (INVALID_ARGUMENT for both). A wish that leaves store, lattice,
   * distances, filter, lowpass, value_type, air_threshold and live at their defaults, without
   * density and exact, gets STORE_WAVELETS where the data suit it (importers/README.md), without a
   * bound of 50 dB outside air and no sample off by more than 2 % of its channel's range. progress
   * (NULL: none) and cancel_token are looked at by create, too. Of a series that goes on
   * (PARTIAL_APPEND) the wish says what its file has: store, lattice and distances; value_step with
   * SET_RANGE and U16, wavelet_errors of STORE_WAVELETS and abs_errors are kept where they are
   * given. UNSUPPORTED: part, as a plan is of the whole series; SET_RANGE without value_step;
   * channels of several value_types (but for those steps) or air_thresholds. */
  const bccsplat_writer_options* wish;
  /* One for each of the wish's channels; NULL: all DEFAULT. */
  const bccsplat_plan_channel* channels;
  /* Times of the frames, wish->dims[3] of them, rising strictly; NULL: 0, 1, 2 ... */
  const double* times;
  /* Not NULL, unless `boxes` is given. */
  bccsplat_source_fn frame;
  void* frame_user; /* of `boxes`, too */
  /* Lattice sites per source sample to choose distances for, up to 4; 0: as the data need, a half
   * where nothing else is asked for. INVALID_ARGUMENT with distances that are given. */
  double density;
  /* Non-zero: values as precise as the source's; 0: rounded where that adds next to nothing to the
   * error of the lattice. */
  int32_t exact;
  /* 0 */
  uint32_t reserved;
  /* In the place of `frame`; NULL: none. */
  bccsplat_boxes_fn boxes;
  /* Bytes that writing may take beside the device's budget, which rules STORE_WAVELETS out where it
   * would take more; 0: half of the machine's memory. */
  uint64_t memory;
  /* What errors name the series by; NULL: "the series". */
  const char* name;
} bccsplat_plan_options;

/* Reads the series, as a whole only where ranges or a bound need that, and tries codings on a
 * sample of it. What options point to is copied or used during the call alone, but for the wish's
 * progress_user and cancel_token, which the options of the plan hand on. CANCELLED as well where
 * `frame` gave up. Also: NOT_FOUND (kernel); UNSUPPORTED; LIMIT_EXCEEDED (as
 * bccsplat_writer_add_frame). */
BCCSPLAT_API bccsplat_status bccsplat_plan_create(
    bccsplat_device* device, const bccsplat_plan_options* options, bccsplat_plan** plan);
/* Returns options that are complete: those of the wish, and all that was chosen. What they point to
 * belongs to the plan, until it is refined or released. */
BCCSPLAT_API bccsplat_status bccsplat_plan_get_writer_options(
    const bccsplat_plan* plan, bccsplat_writer_options* options);
/* Returns what was chosen and why, in English for people: "d4star, distances 1 x 1 x 1 x 1.4 ...".
 * The text belongs to the plan, until it is refined or released. */
BCCSPLAT_API bccsplat_status bccsplat_plan_get_text(const bccsplat_plan* plan, const char** text);
/* Returns what was found and tried until create ended, as JSON. An object with those of these that
 * are known: "channels" (range, samples, relevant, nonfinite, missing_frames ... of each, where all
 * frames were read), "labels" (by channel), "spectrum", "motion", "choice" (lattices tried),
 * "wavelets", "coding" (codings tried for a bound), "still", "no_levels" (why), and "texts" of
 * these; bcc4 import --dry-run --json shows them. More keys may come. The text belongs to the plan.
 */
BCCSPLAT_API bccsplat_status bccsplat_plan_get_json(const bccsplat_plan* plan, const char** json);
/* After a writer with the plan's options ended with BOUND_NOT_MET at its psnr: makes the steps of
 * the plan finer, and in the end has samples corrected. The file is written again from the start;
 * after three of these calls at most it keeps its psnr. NOT_FOUND where nothing is left to try. */
BCCSPLAT_API bccsplat_status bccsplat_plan_refine(bccsplat_plan* plan);
BCCSPLAT_API void bccsplat_plan_retain(bccsplat_plan* plan);
BCCSPLAT_API void bccsplat_plan_release(bccsplat_plan* plan);

/* ---- Volume: an open .bcc4 ---- */

typedef struct bccsplat_volume bccsplat_volume;

typedef struct bccsplat_volume_options {
  uint32_t struct_size;
  /* Non-zero: damaged parts of the file read as holes instead of failing; a damaged mask of missing
   * samples is that of the nearest frame whose mask is whole, or where there is none nothing counts
   * as missing; otherwise only points within the kernel's reach of the damage are lost. In files of
   * samples, points a few sites further, where the prefilter reaches, may miss a bound, and so may
   * those whose corrections are damaged. Preamble, metadata and the list of index pages must be
   * whole: they are the last bytes of a file, and one that was cut is TRUNCATED at opening. Bytes
   * that are gone later, of a file cut while it is open or behind a read_at that gives fewer than
   * asked for, are damage like others. Bytes that cannot be read now are not: calls that need them
   * end with IO, and try again when they are made again. 2: bytes that cannot be read count as
   * damaged as well (a disk with bad sectors), and may do so for as long as the volume is open. */
  int32_t salvage;
  /* Reconstruction; NULL: the file's recommendation. fast, default, fine, exact (CC), paper,
   * gauss09 or SPACE+TIME such as "radial18+b3". */
  const char* kernel;
  /* For decoded chunks, samples and coefficients; 0: enough to play the series forward by up to
   * half a frame at a time with nothing decoded or prefiltered twice, but not more than a quarter
   * of the budget and half of the machine's memory; at least a quarter of the budget, up to 1
   * GiB. */
  uint64_t cache_bytes;
  /* NULL: none; open looks at it as well. */
  bccsplat_cancel_token* cancel_token;
  /* Factors on x, y and z of the world, 1e-30 to 1e30, for example for axes in different units,
   * whose proportions are not known. Everything in the world, returned or passed in, has that
   * shape: affines, points, slices, gradients, pictures. 0 0 0: as stored. */
  double shape[3];
} bccsplat_volume_options;

/* Whether a series may get more frames, which bccsplat_volume_reopen sees. */
typedef int32_t bccsplat_series_state;
enum {
  BCCSPLAT_SERIES_FINISHED = 0,
  /* It is being written, or was left, and is to have frames_expected frames; where that is dims[3]
   * all can be looked at, and finish alone is missing. */
  BCCSPLAT_SERIES_UNFINISHED = 1,
  /* The same, but nobody knows how many it will have. */
  BCCSPLAT_SERIES_OPEN_END = 2
};

typedef struct bccsplat_volume_info {
  uint32_t struct_size;
  bccsplat_lattice lattice;
  /* Source samples per axis. */
  uint64_t dims[4];
  /* Product of dims. */
  uint64_t cc_samples;
  /* Lattice sites per channel, those outside the faces not counted. */
  uint64_t sites_total;
  uint64_t layer_count;
  /* Lattice distance in source samples as asked for; where those along x, y and z differ their
   * geometric mean. */
  double scale;
  double time_scale;
  /* Index space -> world; of a volume with unevenly spaced axes (bccsplat_volume_get_axis) even
   * positions -> world, for which spatial_unit is "". */
  double affine[16];
  /* Time of frame 0. */
  double time_first;
  /* Time of frame dims[3] - 1. */
  double time_last;
  /* Cube root of a voxel's world volume. */
  double mean_voxel;
  /* "" when unknown. */
  const char* spatial_unit;
  const char* time_unit;
  /* Canonical name of the kernel in use. */
  const char* kernel;
  const char* recommended_kernel;
  uint32_t channel_count;
  /* 1: equal steps. */
  int32_t time_uniform;
  bccsplat_store store;
  int32_t has_holes;
  uint64_t bytes_file;
  uint64_t bytes_runs;
  uint64_t bytes_values;
  uint64_t bytes_index;
  /* Bytes read from the file so far, through this handle. */
  uint64_t bytes_read;
  uint64_t attribute_count;
  /* A part of a series has the frames part_first .. part_end-1, the rest is air. */
  uint64_t part_first;
  /* 0: a whole file. */
  uint64_t part_end;
  /* Lattice distance as it is, along x, y, z in source samples and along t in frames; of a volume
   * without time 0 along t. */
  double scales[4];
  /* Planes of the lattice outside the first sample along x, y, z. */
  uint32_t planes_before[3];
  /* Planes outside the last one. */
  uint32_t planes_behind[3];
  /* Lattice sites per channel on these planes. */
  uint64_t sites_outside;
  /* Coarser levels, 1 .. level_count beside level 0; see get_level_info. */
  uint32_t level_count;
  /* 1: the last frame leads to the first (BCCSPLAT_ENDS_PERIODIC), and times and indices go on to
   * time_end and dims[3], which are those of frame 0 again. */
  uint32_t time_periodic;
  /* Time of the last moment to look at: time_last, and where time_periodic later by the mean
   * distance of frames. */
  double time_end;
  /* Frames that a series being written, or left unfinished, is to have; dims[3], those that can be
   * looked at, where that is not known (series_state tells). Opened again the file may have more of
   * them. 0: it is finished. */
  uint64_t frames_expected;
  /* BCCSPLAT_PERIODIC_..., the sum: along these indices go on to dims[axis], which is that of
   * sample 0 again. */
  uint32_t periodic_axes;
  bccsplat_series_state series_state;
  /* A part that is a block of space has the samples part_box_begin .. part_box_end-1 along x, y, z;
   * one of all of space 0 .. dims-1; of a whole file 0. */
  uint64_t part_box_begin[3];
  uint64_t part_box_end[3];
} bccsplat_volume_info;

/* A level of a volume. All other information of a volume is about level 0. */
typedef struct bccsplat_level_info {
  uint32_t struct_size;
  /* Layers that are stored together, a slab: the first ones, the next ones and so on. What reads
   * one of its frames has read much of the others. */
  uint32_t slab_layers;
  /* Lattice distance as it is, as in bccsplat_volume_info. */
  double scales[4];
  uint64_t layer_count;
  /* Lattice sites per channel, those outside the faces not counted. */
  uint64_t sites_total;
  /* Stored sites of all channels, those outside the faces counted. */
  uint64_t sites_kept;
  /* Bytes of its samples in the file, without the index. */
  uint64_t bytes;
  /* Error of the level at source samples, measured at some of them while the file was written: the
   * largest of any channel, in units of its source's range; 0: not measured. Level 0 has one where
   * the file has levels or a bound. */
  double relative_rmse;
} bccsplat_level_info;

typedef struct bccsplat_channel_info {
  uint32_t struct_size;
  /* On disk. */
  bccsplat_type value_type;
  const char* name;
  const char* unit;
  double air;
  double air_threshold;
  /* value = stored * value_scale + value_offset. */
  double value_scale;
  double value_offset;
  /* Smallest and largest source value. */
  double range[2];
  /* Smallest and largest stored sample. */
  double kept_range[2];
  /* Percentiles of the stored samples, from a 256-bin histogram over kept_range. */
  double percentile_2;
  double percentile_998;
  uint64_t sites_kept;
  uint64_t cc_relevant;
  uint64_t holes;
  /* Stored samples per bin over kept_range, the last bin closed. */
  uint64_t histogram[256];
  bccsplat_type source_type;
  /* Non-zero: points have the value of the nearest sample, as bccsplat_volume_evaluate says. */
  int32_t labels;
  /* With the recommended kernel no finite source sample is off by more; 0: none was asked for. */
  double error_bound;
  /* Errors of a file with a bound at the finite source samples, of the lattice alone and with
   * corrections. The range of the source is the peak of their PSNR. 0: not measured. */
  double lattice_rmse;
  double lattice_max_abs;
  double rmse;
  double max_abs;
  /* Number of source samples with a correction. */
  uint64_t corrections;
  /* Number of source samples that the file's masks say are missing; 0 in files whose lattice has
   * holes instead. */
  uint64_t missing;
  /* Root mean square error that the sites of every slab of STORE_WAVELETS may have
   * (bccsplat_writer_options.wavelet_errors); 0 for other stores. */
  double wavelet_error;
} bccsplat_channel_info;

/* Result of a full check of the checksums. Damage and unreadable places are counted separately. */
typedef struct bccsplat_verify_report {
  uint32_t struct_size;
  uint32_t reserved;
  uint64_t chunks;
  uint64_t chunks_damaged;
  uint64_t bytes_checked;
  /* File offset; 0 when none. */
  uint64_t first_damaged_offset;
  /* Damaged places: chunks, index pages, records; 0: everything that was read is sound. */
  uint64_t damages;
  /* Places that a disk or stream failed to read, which are in none of the numbers above but
   * `chunks`; 0: all was read. */
  uint64_t unreadable;
  /* File offset; 0 when none. */
  uint64_t first_unreadable_offset;
} bccsplat_verify_report;

/* Opens a file. Reads its index roots only, and reports no progress. options may be NULL. Also:
 * opening, NOT_FOUND (kernel). */
BCCSPLAT_API bccsplat_status bccsplat_volume_open_file(bccsplat_device* device, const char* path,
    const bccsplat_volume_options* options, bccsplat_volume** volume);
/* `bytes` is borrowed until the last release of the volume and its slices. Also: as above. */
BCCSPLAT_API bccsplat_status bccsplat_volume_open_memory(bccsplat_device* device, const void* bytes,
    uint64_t size, const bccsplat_volume_options* options, bccsplat_volume** volume);
/* A read_at that gives fewer bytes than it was asked for is not asked again: the file ends there
 * (TRUNCATED; with salvage damage). Also: as above. */
BCCSPLAT_API bccsplat_status bccsplat_volume_open_stream(bccsplat_device* device,
    const bccsplat_read_stream* stream, const bccsplat_volume_options* options,
    bccsplat_volume** volume);
/* Opens the file of a volume again, under the options that it was opened with, to see the frames
 * that were added since: live viewing of a series that is being written. The new handle begins with
 * the contents of the other one's caches that more frames do not change: decoded chunks, and
 * coefficients that do not depend on layers beyond the old end, all at once and without being read
 * or made again. They are the same bytes of memory as long as both handles keep them. Slices and
 * scenes keep the old handle, which is still what it was. stream NULL: the file or memory that the
 * volume was opened from, as it is now, a file also under the name that finish gave it. A stream
 * that has grown is passed anew. A file that turns out to hold another series is opened with empty
 * caches, and so is a volume that salvages. The volume's cancel token is that of the new handle.
 * Also: opening. */
BCCSPLAT_API bccsplat_status bccsplat_volume_reopen(
    const bccsplat_volume* volume, const bccsplat_read_stream* stream, bccsplat_volume** newer);
BCCSPLAT_API void bccsplat_volume_retain(bccsplat_volume* volume);
BCCSPLAT_API void bccsplat_volume_release(bccsplat_volume* volume);
BCCSPLAT_API bccsplat_status bccsplat_volume_get_info(
    const bccsplat_volume* volume, bccsplat_volume_info* info);
/* Reads the index of the level. Also: NOT_FOUND beyond level_count, reading. */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_level_info(
    const bccsplat_volume* volume, uint32_t level, bccsplat_level_info* info);
/* Reads nothing; of files written before they told it the tables of corrections and masks, to count
 * them. Also: NOT_FOUND past the last
 * channel, reading. */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_channel_info(
    const bccsplat_volume* volume, uint32_t channel, bccsplat_channel_info* info);
/* Index of the channel of that name. Also: NOT_FOUND. */
BCCSPLAT_API bccsplat_status bccsplat_volume_find_channel(
    const bccsplat_volume* volume, const char* name, uint32_t* channel);
/* Writes min(capacity, dims[3]) frame times; times may be NULL when capacity is 0. count (may be
 * NULL) gets dims[3]. */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_times(
    const bccsplat_volume* volume, double* times, uint64_t capacity, uint64_t* count);
/* Where the samples stand along an axis of space, 0 .. 2 (NOT_FOUND); the array and the unit belong
 * to the volume. An axis that is evenly spaced has count 0 and in a volume without any other no
 * unit of its own: that is spatial_unit. */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_axis(
    const bccsplat_volume* volume, uint32_t axis, bccsplat_axis* info);
/* Index space -> world and back, of n places, n x 3 doubles each; `from` and `to` may be the same.
 * Along unevenly spaced axes by their coordinates, monotone cubic between samples; the way back is
 * right to 1e-12 of the axis. Beyond the outermost samples they go on straight. */
BCCSPLAT_API bccsplat_status bccsplat_volume_index_to_world(
    const bccsplat_volume* volume, uint64_t n, const double* from, double* to);
BCCSPLAT_API bccsplat_status bccsplat_volume_world_to_index(
    const bccsplat_volume* volume, uint64_t n, const double* from, double* to);
/* Smallest and largest finite value that the source had in each frame, 0 twice in one without any:
 * writes the first min(capacity, count) pairs; ranges: 2 x capacity doubles, may be NULL when
 * capacity is 0. count (may be NULL) gets dims[3], or 0 where the file has none: files of layers,
 * fields and parts. Reads nothing. Also: NOT_FOUND past the last channel. */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_frame_ranges(const bccsplat_volume* volume,
    uint32_t channel, double* ranges, uint64_t capacity, uint64_t* count);
/* Time unit -> frame index and back; monotone cubic between uneven times. Also: OUT_OF_DOMAIN
 * outside the series, 0 to time_end and its index. */
BCCSPLAT_API bccsplat_status bccsplat_volume_time_to_index(
    const bccsplat_volume* volume, double time, double* index);
BCCSPLAT_API bccsplat_status bccsplat_volume_index_to_time(
    const bccsplat_volume* volume, double index, double* time);
/* Attribute by index, 0 .. attribute_count-1, or by key; the strings belong to the volume. Also:
 * NOT_FOUND. */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_attribute(
    const bccsplat_volume* volume, uint64_t index, const char** key, const char** value);
BCCSPLAT_API bccsplat_status bccsplat_volume_find_attribute(
    const bccsplat_volume* volume, const char* key, const char** value);
/* Where the data came from, by index from 0 on: name, size in bytes, CRC-32 (0: unknown); each
 * output may be NULL. The string belongs to the volume. Also: NOT_FOUND past the last. */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_source(const bccsplat_volume* volume,
    uint64_t index, const char** name, uint64_t* bytes, uint32_t* crc32);
/* The field of channel 0 at n points. xyzt: n x 4 doubles, index space. values: n floats.
 * gradients: NULL or n x 4 floats, d/dx d/dy d/dz d/dt in value per index unit: the derivatives of
 * the values at the point, corrections included. Differences of values are as near to them as
 * their points are close: with the kernels default and fine, of points 0.02 apart, to within 0.5 %
 * of the largest. Where the field bends (kernel fast at the times of layers, corrections of older
 * files at samples) they are those of one side, and where it jumps (paper, gauss09) those between
 * jumps. Every point is evaluated even when the call fails with OUT_OF_DOMAIN or HOLE: the points
 * concerned get NaN, and the error's text names the first of them outside and its axis. A point
 * beyond an end by what rounding makes, 1e-9 of the axis, is inside. A static volume ignores t. Of
 * points in few places, only the data around these are read and made. Where a file was written
 * with FACES_MIRROR or ENDS_MIRROR the field is mirrored at its ends for the kernel's sake: within
 * three samples of such an end it is less accurate where the field is not level there, in values
 * and derivatives alike. A channel of labels (bccsplat_channel_info.labels: on the source's own
 * grid, where the writer or the values say so) has at any point the value of the sample nearest to
 * it in space and time, and gradients of 0; so have slices of it normal to an axis, which are made
 * through the nearest samples, and their composites. Other slices and modes, and trails, show the
 * field through the samples. The token of the volume cancels it; for progress a host hands over its
 * points in parts. Also: reading, OUT_OF_DOMAIN, HOLE, UNSUPPORTED (on CC, a kernel that reaches
 * further than 2 T). */
BCCSPLAT_API bccsplat_status bccsplat_volume_evaluate(
    const bccsplat_volume* volume, uint64_t n, const double* xyzt, float* values, float* gradients);
/* The same for any channel. Also: NOT_FOUND (channel). */
BCCSPLAT_API bccsplat_status bccsplat_volume_evaluate_channel(const bccsplat_volume* volume,
    uint32_t channel, uint64_t n, const double* xyzt, float* values, float* gradients);
/* The same at places in the world: xyzt: n x 4 doubles, x y z in the unit of space and the time, as
 * bccsplat_volume_index_to_world and bccsplat_volume_index_to_time place its indices. gradients:
 * value per world length and per time unit. missing: NULL, or it gets the number of points outside
 * or in holes, whose values are NaN, and these are no error. Many points at one moment, such as the
 * planes of a linked view, are read sooner from a slice on a Cartesian lattice:
 * bccsplat_volume_slice_at once, then bccsplat_slice_evaluate. */
BCCSPLAT_API bccsplat_status bccsplat_volume_evaluate_world(const bccsplat_volume* volume,
    uint32_t channel, uint64_t n, const double* xyzt, float* values, float* gradients,
    uint64_t* missing);
/* The values of a channel at the source's samples of one frame, which is what a time slice has
 * there (bccsplat_slice_sample_grid) but for rounding. begin, end: the first sample along x, y, z
 * and the one behind the last; both NULL: all. values: end - begin floats along each axis, x
 * fastest; NaN in holes. Where the field goes through the samples that are stored, as with kernel
 * "exact" on a Cartesian lattice of the source's own distances, which imports choose by default,
 * they are handed over as they are: only the box itself is read and decoded, of its frame alone.
 * Elsewhere a slice of the box is made. Labels and whole numbers that are stored without loss come
 * back as they were. The token of the volume cancels it. Also: NOT_FOUND (channel), OUT_OF_DOMAIN
 * (frame, box), INVALID_ARGUMENT (an empty box), LIMIT_EXCEEDED, reading. */
BCCSPLAT_API bccsplat_status bccsplat_volume_read_frame(const bccsplat_volume* volume,
    uint32_t channel, uint64_t frame, const uint64_t* begin, const uint64_t* end, float* values);
/* Reads the whole file and checks every checksum and structural rule. OK even when damage is found:
 * see the report. The device's log gets a line for each damage, which says where it is and which
 * samples and frames are lost, and one that lists the frames that are whole. A place that a disk or
 * stream fails to read is no damage: the rest is checked all the same, `unreadable` counts such
 * places, the log says where and why, and the call ends with IO, but with the report filled.
 * progress may be NULL. Also: IO, WOULD_BLOCK. */
BCCSPLAT_API bccsplat_status bccsplat_volume_verify(const bccsplat_volume* volume,
    bccsplat_progress_fn progress, void* progress_user, bccsplat_verify_report* report);

/* ---- Slice: the 3D field on a hyperplane ---- */

typedef struct bccsplat_slice bccsplat_slice;

/* a x + b y + c z + d t + e = 0 in index space; (a, b, c, d) any length but zero, e no more than
 * 1e30 times that. A time slice at frame f: d = 1, e = -f. Planes of space at one moment, as the
 * linked views of a medical viewer, are none: their points are asked of the time slice
 * (bccsplat_slice_sample_grid, _evaluate) or by their places in the world
 * (bccsplat_volume_evaluate_world). A volume without time has no other (UNSUPPORTED). */
typedef struct bccsplat_hyperplane {
  uint32_t struct_size;
  uint32_t reserved; /* 0 */
  double a, b, c, d, e;
} bccsplat_hyperplane;

/* A slab holds, at each point of the hyperplane, the field's mean, its integral (SUM: value times
 * index units) or its largest value along the normal. Mean and sum of merged slices are exact
 * (integrals of the kernel); else they are Gauss-Legendre quadrature with 1.5 nodes per index unit
 * and 3 more. MAXIMUM is the largest value at the nodes of that quadrature, which stand at most 0.8
 * index units apart. */
typedef int32_t bccsplat_slab;
enum {
  BCCSPLAT_SLAB_DEFAULT = 0, /* MEAN */
  BCCSPLAT_SLAB_MEAN = 1,
  BCCSPLAT_SLAB_SUM = 2,
  BCCSPLAT_SLAB_MAXIMUM = 3
};

/* Corrections of a file (bccsplat_writer_options.abs_error) are part of the field under the kernel
 * they were made for: values and gradients, slices, pictures, trails. Time slices have them
 * exactly. Other slices are mended at points 1 index unit apart, from the first corner of their box
 * on, to within a 32nd of the bound of the volume's field there: x, y and z slices through source
 * samples err by at most 33/32 of the bound there. EXTRACTED slices, other kernels and the coarser
 * slices that small pictures are drawn from (SKIP_FINE_DETAIL) have none.
 *
 * How a slice is made. DEFAULT is MERGED where that can be, else RESAMPLED.
 *   MERGED     t, x, y or z = constant: the layers or planes of sites in reach, weighted; the slice
 *              is on the volume's lattice. Exact for time slices; an axis slice is the time slice
 *              of the volume with its axes turned, under the kernel turned with them.
 *   RESAMPLED  the 4D field at the sites of a lattice in the hyperplane, then interpolated. With
 *              the kernel "paper" this is equation (6) of Neophytou & Mueller 2002.
 *   EXTRACTED  their extraction, for comparison: every 4D point within 2 T of the hyperplane,
 *              weighted by its distance and splatted as a 3D Gaussian exp(-2 r^2), the sum divided
 *              by that of a lattice without ends. Series on D4* or Cartesian lattices, without
 *              thickness, interval, spacing and lattice. No trails; the kernel is "paper". Beyond
 *              the ends of the domain stand mirror images of the points inside, as for every slice.
 */
typedef int32_t bccsplat_method;
enum {
  BCCSPLAT_METHOD_DEFAULT = 0,
  BCCSPLAT_METHOD_MERGED = 1,
  BCCSPLAT_METHOD_RESAMPLED = 2,
  BCCSPLAT_METHOD_EXTRACTED = 3
};

/* Coordinates of a slice of a volume with unevenly spaced axes; with even axes both are the same.
 *   INDEX  indices: samples and exports are on the source's grid. Such a slice is not drawn: its
 *          affine holds at the corners of the domain alone (set_slice takes it, render answers
 *          UNSUPPORTED).
 *   EVEN   even positions: hyperplane, box, slice space, origin, basis and extent are of these,
 *          which the affine takes to the world; pictures are made of such slices. They are
 *          resampled from the volume's field with its corrections, between the closest samples of
 *          an axis finely enough to keep what these tell, up to 32 planes for one of an even axis
 *          and as far as half of the memory budget allows: the log warns where that is too few.
 *          Masks are exact. Merged slices are resampled once more, others point by point, which
 *          reads all of the volume. UNSUPPORTED: EXTRACTED, a thickness across uneven axes. */
typedef int32_t bccsplat_space;
enum { BCCSPLAT_SPACE_DEFAULT = 0, BCCSPLAT_SPACE_INDEX = 1, BCCSPLAT_SPACE_EVEN = 2 };

/* Whether a moment between two frames follows what moves. A kernel in time alone gives back what
 * moves by up to some four samples from frame to frame; what moves further comes back twice, faint.
 *   OFF  The field of the file's kernel.
 *   ON   Where things go is found on the frames around the moment, as the file gives them. Where
 *        that predicts a frame that is left out better, by a margin, the slice has the sum of up to
 *        four frames along the ways; it is that of OFF elsewhere, at frames, and where values are
 *        below 1/1000 of the largest. Each place has one way: of things that pass through each
 *        other at most one is followed. Frames count as layers of time hold them: on a D4* lattice
 *        whose layers are as far apart as frames it gains little. Corrections of a file stay where
 *        they are. An interval is found when it is first looked at, on up to eight frames, in
 *        about the time that the import of one takes, and kept with the volume; prefetch finds it
 *        ahead. A moment then takes 3 to 10 times that of OFF, up to
 *        60 where its layers are held. Merged time slices of all of a
 *        volume at an instant: UNSUPPORTED with a box, thickness or interval, and for other
 *        hyperplanes. Without effect on labels and static volumes; trails do not follow. */
typedef int32_t bccsplat_motion;
enum { BCCSPLAT_MOTION_DEFAULT = 0, BCCSPLAT_MOTION_OFF = 1, BCCSPLAT_MOTION_ON = 2 };

typedef struct bccsplat_slice_options {
  uint32_t struct_size;
  uint32_t channel;
  /* NULL: the volume's. */
  const char* kernel;
  /* Frames relative to the hyperplane's, begin <= 0 <= end allowed in any mix: the slice holds the
   * mean over [t+begin, t+end], each end moved to that of the series it lies beyond; where time is
   * periodic it goes round, up to a turn before frame 0 and a turn behind the end. Both 0: the
   * instant. Time slices only. */
  double interval[2];
  /* Target lattice's distance in index units, up to the largest of dims; 0: 1, and less along axes
   * where the volume's lattice is finer. Any other value (for time slices except 1) resamples. A
   * coarser slice is low-passed to the band of its own lattice: at half of that Nyquist rate 98 %
   * are kept, at the rate itself 24 %, from 1.3 times it on less than 1 %. LIMIT_EXCEEDED where it
   * makes more than 1e6 planes along an axis. */
  double spacing;
  /* World units that one frame is drawn as off the time axis, at least 1e-30; 0: one mean voxel. */
  double time_length;
  /* Target: BCC or CC; DEFAULT: the volume's where the slice is merged, else BCC. */
  bccsplat_lattice lattice;
  /* Level of the volume: 0: all of it; l in 1 .. level_count: its coarser lattice l, with an eighth
   * of the points and work for each, without the file's corrections; NOT_FOUND beyond. Of
   * labels, which have no means, level 0 stands for all. A slice that is resampled has the same
   * spacing at every level. */
  uint32_t level;
  /* NULL: none; about the share of the work done, 1 at success. */
  bccsplat_progress_fn progress;
  void* progress_user;
  /* Thickness of a slab around the hyperplane, in index units along its unit normal (time slices:
   * frames), clipped to the domain, for time slices as an interval is. 0: none. A slab that has to
   * be sampled is LIMIT_EXCEEDED above 2000 index units. Excludes interval. */
  double thickness;
  /* 4 doubles, index space: the origin of slice space. NULL: chosen, with the basis. */
  const double* point;
  /* 3 x 4 doubles: directions of u, v, w in index space, any lengths, orthonormalised in order.
   * With point and basis, which are copied and go together, the slice is resampled on a lattice
   * along them, and hyperplane must be NULL. */
  const double* basis;
  bccsplat_slab slab;
  bccsplat_method method;
  /* 6 doubles, which are copied: x0 y0 z0 x1 y1 z1 in index units, clipped to the samples; one that
   * misses them is OUT_OF_DOMAIN, one that ends before it begins INVALID_ARGUMENT. The slice is
   * that part of a merged time slice, ends included, and costs what the part costs: only chunks up
   * to about two dozen sites around it are read. It has the values of the whole slice. Where it
   * ends where it begins it is a plane, line or point, which can be evaluated and sampled, and is
   * drawn one sample thick. There are no clip planes: a box stands for those along the axes, and
   * the samples of a deep picture (FRAME_DEEP with opacity_stop 1) are cut wherever a host likes. A
   * volume keeps a cache for the last box of a channel and kernel beside that for the whole. NULL:
   * all of it. */
  const double* box;
  /* NULL: none. */
  bccsplat_cancel_token* cancel_token;
  /* DEFAULT: INDEX. */
  bccsplat_space space;
  /* Non-zero: no other moment of this part of the series will be asked for soon. A time slice of
   * wavelets on a Cartesian lattice is then made as one sum, in 3/4 of the time, and its layers
   * are not kept, so that the next moment takes longer, and bounds are its own alone; where some
   * layers are there already it is made of those. Values are the same but for rounding. Others: no
   * difference. */
  uint32_t once;
  /* Resampled slices under the kernel "paper": the bandwidths (wx, wy, wz, wt) of the 4D filter of
   * equation (6), in distances of the volume's lattice, 1 .. 64: a site is the mean of the samples
   * around it, weighted by exp(-2 sum ((p - s) / w)^2) within 2 w. Takes the place of the low pass
   * of spacing. All 0: none. UNSUPPORTED: another kernel, MERGED, EXTRACTED, EVEN, a thickness or
   * interval. */
  double bandwidth[4];
  /* DEFAULT: OFF. */
  bccsplat_motion motion;
  uint32_t reserved; /* 0 */
} bccsplat_slice_options;

typedef struct bccsplat_slice_info {
  uint32_t struct_size;
  /* BCC or CC. */
  bccsplat_lattice lattice;
  /* Normalised. */
  double hyperplane[5];
  /* Index space of slice space (0, 0, 0). */
  double origin[4];
  /* Orthonormal directions of u, v, w in index space. An axis slice has the axes that are left, in
   * the order x, y, z, t (x = constant: u, v, w are y, z, t). */
  double basis[3][4];
  /* Domain in slice space. The domain of an empty slice ends before it begins. */
  double extent[3][2];
  /* Samples of the dense box at the source's resolution: sample i at slice coordinate extent[.][0]
   * + i; 0 for an empty slice; n + 1 along a periodic axis of n samples, the last of which is the
   * first again. */
  uint64_t dims[3];
  /* Slice space -> world, row-major. Off the time axis the world has a fourth axis, on which a
   * frame is time_length long; of the four the one nearest to the normal is left out, and the
   * others, in the order x, y, z, t, are projected into the hyperplane and made orthonormal. So
   * planes over time are no mirror images of time slices, and where the volume's affine is along
   * the axes x = constant stands at its (y, z, t). */
  double affine[16];
  /* No value of the slice lies outside. For a moment of a series on a device that draws on a GPU:
   * nor does any value of a moment between the same layers. */
  double bounds[2];
  double air;
  /* Lattice points that take part. */
  uint64_t points;
  /* Bytes read from the file to make this slice. */
  uint64_t bytes_read;
  /* Time to make the slice, in milliseconds. */
  double milliseconds;
  const char* kernel;
  /* Level of the volume that it is made of. */
  uint32_t level;
  uint32_t reserved;
} bccsplat_slice_info;

/* A dense box in slice space: sample (i, j, k) is at origin + step * (i, j, k). */
typedef struct bccsplat_grid {
  uint32_t struct_size;
  uint32_t reserved; /* 0 */
  double origin[3];
  double step[3];
  uint64_t dims[3];
} bccsplat_grid;

/* Cuts a hyperplane. options may be NULL. OUT_OF_DOMAIN: a time outside the series; another
 * hyperplane that misses the domain gives an empty slice: no points, dims 0, every sample NaN.
 * INVALID_ARGUMENT: a zero or non-finite normal, a basis whose directions depend on each other,
 * options that exclude each other. UNSUPPORTED: a method, slab or interval that this hyperplane or
 * volume cannot have. Also: NOT_FOUND (channel, kernel, level), LIMIT_EXCEEDED, reading. */
BCCSPLAT_API bccsplat_status bccsplat_slice_create(const bccsplat_volume* volume,
    const bccsplat_hyperplane* hyperplane, const bccsplat_slice_options* options,
    bccsplat_slice** slice);
/* Cuts the volume at a time in its own unit: bccsplat_slice_create of t = time_to_index(time). A
 * volume without time takes any time. options may be NULL; point and basis are INVALID_ARGUMENT.
 * Also: as bccsplat_slice_create. */
BCCSPLAT_API bccsplat_status bccsplat_volume_slice_at(const bccsplat_volume* volume, double time,
    const bccsplat_slice_options* options, bccsplat_slice** slice);
/* Reads and makes everything that bccsplat_slice_create would with the same arguments, and leaves
 * it in the volume's cache, as far as that has room: for an idle thread of the host's, ahead of a
 * moment that it will ask for. Returns when that is done. Also: as there; UNSUPPORTED: slices other
 * than merged time slices. */
BCCSPLAT_API bccsplat_status bccsplat_volume_prefetch(const bccsplat_volume* volume,
    const bccsplat_hyperplane* hyperplane, const bccsplat_slice_options* options);

/* Bits of the flags of bccsplat_volume_get_ranges. */
enum {
  BCCSPLAT_RANGES_MISSING = 1 /* without what the volume's caches hold */
};

/* The byte ranges of the file that bccsplat_slice_create (or bccsplat_volume_prefetch) with the
 * same arguments reads on a volume whose caches are empty: for a host that fetches them in one go.
 * A time slice with an interval stands for all moments in it, of a level and a box;
 * bccsplat_volume_evaluate at moments of it, and trails over it, may reach a layer further (at most
 * scales[3] frames). Ranges are sorted, and merged where no more than the stream's merge_gap (of
 * files and memory 4096 bytes) lies between them; they cover each read, and index pages,
 * corrections and masks. For slices off the time axis of files with corrections they hold the
 * corrections of whole frames, of which less may be read. Writes the first min(capacity, count)
 * pairs of offset and size; ranges: 2 x capacity integers, may be NULL when capacity is 0; count
 * (may be NULL) gets their number. flags: BCCSPLAT_RANGES_... The bytes that opening reads are not
 * among them. The call reads the index pages that it needs and the tables of corrections, so that
 * it may end with WOULD_BLOCK itself; it makes nothing and leaves the caches of chunks and
 * coefficients as they are. options->progress is called at the end. Also: as
 * bccsplat_slice_create. */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_ranges(const bccsplat_volume* volume,
    const bccsplat_hyperplane* hyperplane, const bccsplat_slice_options* options, uint32_t flags,
    uint64_t* ranges, uint64_t capacity, uint64_t* count);
BCCSPLAT_API void bccsplat_slice_retain(bccsplat_slice* slice);
BCCSPLAT_API void bccsplat_slice_release(bccsplat_slice* slice);
BCCSPLAT_API bccsplat_status bccsplat_slice_get_info(
    const bccsplat_slice* slice, bccsplat_slice_info* info);
/* uvw: n x 3 doubles, slice space. values: n floats. gradients: NULL or n x 3 floats per unit of
 * slice space. Points outside or in holes as for bccsplat_volume_evaluate. Also: OUT_OF_DOMAIN,
 * HOLE. */
BCCSPLAT_API bccsplat_status bccsplat_slice_evaluate(
    const bccsplat_slice* slice, uint64_t n, const double* uvw, float* values, float* gradients);
/* Fills `values` (product of grid->dims floats, x fastest); grid NULL: the box of
 * bccsplat_slice_info. Samples outside the domain or in holes are NaN (no failure). The token of
 * the slice cancels it; for progress a host asks for some planes at a time. */
BCCSPLAT_API bccsplat_status bccsplat_slice_sample_grid(
    const bccsplat_slice* slice, const bccsplat_grid* grid, float* values);
/* The lattice points: writes min(capacity, points) positions (uvw, 3 floats each, slice space) and
 * coefficients relative to air; either array may be NULL. count (may be NULL) gets the number of
 * points. Corrections are in none of them. An EXTRACTED slice lists its 4D points at their places
 * in it, mirror images included, with samples weighted by their distance. */
BCCSPLAT_API bccsplat_status bccsplat_slice_get_points(const bccsplat_slice* slice,
    uint64_t capacity, float* uvw, float* coefficients, uint64_t* count);

/* ---- Bricks: a slice as textures, for a host that draws by its own GPU ---- */

/* What bricks hold.
 *   SAMPLES  values of the field on a Cartesian grid, for the filters of a texture unit.
 *   SITES    what the field is made of: v(s) at each site s, and at a point p
 *              field(p) = empty + sum over the sites of both cosets of (v(s) - empty) phi(|p - s|),
 *              phi(r) = sum over j of kernel[j] u^j, u = max(0, 1 - (r / kernel_radius)^2),
 *            where lengths along each axis are in steps of the grid (bccsplat_brick_info). Sites
 *            beyond the ends of the lattice are in the borders, as the field has them. Without
 *            corrections and holes. UNSUPPORTED: EXTRACTED slices, labels. */
typedef int32_t bccsplat_brick_grid;
enum {
  BCCSPLAT_BRICK_GRID_DEFAULT = 0, /* SAMPLES */
  BCCSPLAT_BRICK_GRID_SAMPLES = 1,
  BCCSPLAT_BRICK_GRID_SITES = 2
};

typedef struct bccsplat_brick_options {
  uint32_t struct_size;
  bccsplat_brick_grid grid;
  /* U8, U16, F16 or F32; DEFAULT: F32. */
  bccsplat_type type;
  /* Samples along each axis that are a brick's own, 4 to 128; 0: 32. */
  uint32_t edge;
  /* Samples on each side of a brick that are its neighbours' too, 0 to 16: at least 1 for linear
   * filters, 2 for cubic ones and for gradients, for SITES kernel_radius rounded up. Beyond the
   * last sample of SAMPLES its value goes on. */
  uint32_t border;
  uint32_t reserved; /* 0 */
  /* SAMPLES: their distance in units of slice space, at most; 0: 1. It is made smaller so that the
   * first and the last sample stand at the ends of the extent. A linear filter smooths the field
   * between samples one unit apart; half a unit shows what the field holds. */
  double spacing;
  /* U8, U16: the values that the smallest and the largest code stand for; what is beyond is one of
   * these. Both 0: all values of the slice. */
  double range[2];
} bccsplat_brick_options;

typedef struct bccsplat_brick_info {
  uint32_t struct_size;
  /* Grids of bricks, one behind the other: SITES of a BCC slice 2, else 1. */
  uint32_t cosets;
  /* Bricks along u, v, w, of each coset; 0 of an empty slice. */
  uint32_t bricks[3];
  /* Samples along each axis of a brick, borders included. */
  uint32_t edge;
  /* Samples along u, v, w of the first coset's grid, without borders; the last bricks may reach
   * beyond. */
  uint64_t dims[3];
  /* Slice space of sample (0, 0, 0) of each coset: the first one that is brick 0's own. */
  double origin[2][3];
  /* Slice units from sample to sample. */
  double step[3];
  /* Bytes of a brick. */
  uint64_t brick_bytes;
  /* value = offset + scale * code for U8 and U16; 1 and 0 for floats. */
  double scale;
  double offset;
  /* The value of bricks that are not listed. */
  double empty;
  /* SITES: of phi above; 0 for SAMPLES. */
  double kernel_radius;
  double kernel[20];
  uint32_t kernel_terms;
  /* 1: the sum is divided by that of phi over all sites, air included: to within a thousandth, as
   * the library knows it in closed form (the kernel "paper"). */
  uint32_t kernel_normalised;
} bccsplat_brick_info;

/* Where the bricks of a slice stand and how they are coded. options may be NULL.
 * INVALID_ARGUMENT: options out of range. LIMIT_EXCEEDED: more than 2^20 samples along an axis or
 * 2^31 - 1 bricks. */
BCCSPLAT_API bccsplat_status bccsplat_slice_get_brick_info(
    const bccsplat_slice* slice, const bccsplat_brick_options* options, bccsplat_brick_info* info);
/* Which bricks hold data. Cell (i, j, k) of coset c is number ((c * bricks[2] + k) * bricks[1] + j)
 * * bricks[0] + i. index: for each cell 0 where the brick holds `empty` alone, else 1 for the first
 * that does not, 2 for the next, and so on: a host's texture of brick numbers, of which 0 is one
 * brick of `empty`. bounds: for each cell two floats that no value of the brick, its border
 * included, is below or above; found without making the values, so that these need not reach them.
 * Either array may be NULL. count (may be NULL) gets how many are not empty. Also: as
 * bccsplat_slice_get_brick_info. */
BCCSPLAT_API bccsplat_status bccsplat_slice_find_bricks(const bccsplat_slice* slice,
    const bccsplat_brick_options* options, uint32_t* index, float* bounds, uint64_t* count);
/* Makes the bricks of `count` cells, by all threads of the device: brick_bytes for each in
 * `values`, x fastest, one brick behind the other in the order of `cells`; aligned as the type.
 * NaN where nothing is: outside the domain of an oblique slice, in holes; as U8 and U16 `empty`.
 * ranges: NULL, or two floats for each brick, the smallest and the largest value before they are
 * coded; NaN where there is none. The token of the slice cancels it. Also: as
 * bccsplat_slice_get_brick_info; INVALID_ARGUMENT: a cell that is not there. */
BCCSPLAT_API bccsplat_status bccsplat_slice_get_bricks(const bccsplat_slice* slice,
    const bccsplat_brick_options* options, uint64_t count, const uint32_t* cells, void* values,
    float* ranges);

/* ---- Renderer ---- */

typedef struct bccsplat_renderer bccsplat_renderer;
typedef struct bccsplat_frame bccsplat_frame;

typedef int32_t bccsplat_projection;
enum {
  BCCSPLAT_PROJECTION_DEFAULT = 0,
  BCCSPLAT_PROJECTION_ORTHOGRAPHIC = 1,
  BCCSPLAT_PROJECTION_PERSPECTIVE = 2
};

/* World space. An orthographic camera draws all of the slice along its direction, also the part
 * behind its position, at negative depths; a perspective one draws the part in front of it. The
 * image plane's height is ortho_height (world units) or spans fovy_degrees; its width follows from
 * the frame's aspect ratio (square pixels). */
typedef struct bccsplat_camera {
  uint32_t struct_size;
  /* DEFAULT: orthographic. */
  bccsplat_projection projection;
  double position[3];
  /* Position and target must differ, up must not be parallel to the view. */
  double target[3];
  /* All coordinates up to 1e36. */
  double up[3];
  /* Perspective: 0.001 to 170 (INVALID_ARGUMENT beyond: a narrower view is an orthographic one, and
   * little of a wider one would be drawn). Up to 2.1 it may be meant in radians: the log gets a
   * warning once per device. From within a volume, matter nearer than about a sheet's distance is
   * not drawn: at more than some 150 degrees that is much of the picture. */
  double fovy_degrees;
  /* Orthographic: 1e-36 to 1e36. */
  double ortho_height;
} bccsplat_camera;

/* A view of the whole slice. It starts looking along +z of world space with +y up, so that +x
 * points to the left, and is turned about the slice's centre: first by rotate_y about the vertical
 * (positive: the view turns from +z towards +x), then by rotate_x about the horizontal axis
 * (positive: the camera rises and looks down). It fits the bounding sphere of what is drawn of the
 * slice (one sample thick along an axis that has one sample) into the smaller side of a
 * width x height image. Perspective uses 30 degrees. Angles are at most 1e6 either way. */
BCCSPLAT_API bccsplat_status bccsplat_slice_fit_camera(const bccsplat_slice* slice,
    int32_t projection, double rotate_x_degrees, double rotate_y_degrees, uint32_t width,
    uint32_t height, bccsplat_camera* camera);

/* The side of the world that a fitted view shows before it is turned: the axes that point to the
 * right and up in its picture. */
typedef int32_t bccsplat_side;
enum {
  BCCSPLAT_SIDE_DEFAULT = 0, /* FRONT */
  BCCSPLAT_SIDE_BACK = 1,    /* -x right, y up: looks along z, as bccsplat_slice_fit_camera */
  BCCSPLAT_SIDE_FRONT = 2,   /* x right, y up: looks against z, as maps have it */
  /* -x right, z up: a patient's face, where x runs to the right, y to the front and z to the head
   * (NIfTI). */
  BCCSPLAT_SIDE_ANTERIOR_RAS = 3,
  /* x right, z up: the same where x runs to the left and y to the back (DICOM, ITK). */
  BCCSPLAT_SIDE_ANTERIOR_LPS = 4
};

/* Request for a fitted view. */
typedef struct bccsplat_fit {
  uint32_t struct_size;
  /* DEFAULT: orthographic. */
  bccsplat_projection projection;
  bccsplat_side side;
  /* 0 */
  uint32_t reserved;
  /* Degrees, at most 1e6 either way: first about the vertical of the picture (positive: the camera
   * goes to the right), then about its horizontal (positive: the camera rises and looks down). */
  double rotate_x_degrees;
  double rotate_y_degrees;
  /* A box of the world, x0 y0 z0 x1 y1 z1, as bccsplat_slice_get_seen_bounds or
   * bccsplat_scene_get_bounds gives it. */
  double bounds[6];
} bccsplat_fit;

/* A view that a box fills, but for a margin of 4 % on either side, when it is turned about the
 * vertical to where it needs most: its size is the same for every rotate_y_degrees, as turntables
 * want it. Perspective uses 30 degrees. */
BCCSPLAT_API bccsplat_status bccsplat_fit_camera(
    const bccsplat_fit* fit, uint32_t width, uint32_t height, bccsplat_camera* camera);
/* The side that people who know the data look at first: ANTERIOR of a file whose world is a
 * patient's, by its attribute "space" (right-anterior-superior, left-posterior-superior, or RAS,
 * LPS), else FRONT. Planes over time have no such side but FRONT. */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_side(
    const bccsplat_volume* volume, bccsplat_side* side);

/* ---- View: a host's camera, its opaque things, clips ---- */

/* How device depth runs between the near and the far plane. */
typedef int32_t bccsplat_depth_range;
enum {
  BCCSPLAT_DEPTH_RANGE_DEFAULT = 0,
  BCCSPLAT_DEPTH_RANGE_ZERO_ONE = 1,      /* 0 .. 1: Direct3D, Metal, Vulkan */
  BCCSPLAT_DEPTH_RANGE_MINUS_ONE_ONE = 2, /* -1 .. 1, in a depth buffer 0 .. 1: OpenGL */
  BCCSPLAT_DEPTH_RANGE_REVERSED = 3       /* 1 .. 0 */
};

/* Meaning of the numbers of a depth plane. */
typedef int32_t bccsplat_depth_kind;
enum {
  /* DEVICE where the view has matrices, else PLANAR. */
  BCCSPLAT_DEPTH_DEFAULT = 0,
  /* World distance along the view direction from the camera position, as FRAME_DEPTH has it. */
  BCCSPLAT_DEPTH_PLANAR = 1,
  /* World distance along the pixel's ray; in orthographic views the same as PLANAR. */
  BCCSPLAT_DEPTH_RAY = 2,
  /* Contents of a depth buffer, 0 .. 1, by the view's matrices and depth_range. */
  BCCSPLAT_DEPTH_DEVICE = 3
};

/* Where a picture is seen from, and the host's own opaque scene around it. A cleared struct is the
 * default view. A view that has matrices or a camera may be used for any volume in that world.
 * Matter behind the eye is not drawn, except by an orthographic camera, whose position is any point
 * along the rays. Near and far plane define device depth and clip nothing. Pixel (i, j), counted
 * from the top left one, has its centre at (i + 0.5, j + 0.5). */
typedef struct bccsplat_view {
  uint32_t struct_size;
  /* Non-zero: the two matrices count; 0: camera. */
  uint32_t use_matrices;
  /* NULL: the default view (orthographic, rotate_x 20, rotate_y 30, fitted to the slice or
   * scene). */
  const bccsplat_camera* camera;
  /* For columns: clip = projection (world_to_view (x, y, z, 1)); row-major, entry [4 row + column],
   * unless column_major. In perspective the last row of projection gives the distance in front of
   * the eye (w > 0); off-axis frusta, unequal pixels, mirror images and either handedness are
   * fine. */
  double world_to_view[16];
  double projection[16];
  /* Non-zero: both are stored column by column, as OpenGL does. */
  uint32_t column_major;
  /* Depth range of the matrices. DEFAULT: ZERO_ONE. */
  bccsplat_depth_range depth_range;
  /* Non-zero: y = +1 after projection is the bottom of the picture (Vulkan), not its top. */
  uint32_t y_down;
  /* Meaning of `depth`. */
  bccsplat_depth_kind depth_kind;
  /* The frame is a part of a picture of picture_size pixels, its top left pixel at region_begin;
   * both sizes 0: it is the whole picture. A picture drawn in parts is the picture, but for edges
   * of isosurfaces (smooth_edges), which are found by two pixels on each side: a part two pixels
   * larger on each side has them. */
  uint32_t picture_size[2];
  uint32_t region_begin[2];
  /* The host's opaque scene, one float per pixel of the frame, row 0 at the top: rays end there.
   * NaN, infinity and device depth at the far plane: nothing is there. NULL: none. Borrowed: by
   * bccsplat_renderer_set_view until another view is set or the last release, by other calls while
   * they last. */
  const float* depth;
  /* From one row to the next, a multiple of 4, negative for rows from the bottom up (depth then
   * points to the row at the top); 0: packed. */
  int64_t depth_row_bytes;
  /* The host's picture, 4 floats per pixel, linear and premultiplied, which the volume is drawn
   * over: the frame gets both. NULL: none. Borrowed as depth. */
  const float* background;
  int64_t background_row_bytes;
} bccsplat_view;

/* A half-space that is kept: normal . p + offset >= 0. */
typedef int32_t bccsplat_clip_space;
enum {
  BCCSPLAT_CLIP_SPACE_DEFAULT = 0, /* world */
  BCCSPLAT_CLIP_SPACE_WORLD = 1,
  BCCSPLAT_CLIP_SPACE_VOLUME = 2 /* the volume's own world, before an instance's placement */
};
typedef struct bccsplat_clip {
  /* Any length from 1e-30 on. */
  double normal[3];
  double offset;
  bccsplat_clip_space space;
  /* 0 */
  uint32_t reserved;
  /* In a scene: the instance that is cut, 0: all. In a renderer: 0. */
  uint64_t instance;
} bccsplat_clip;
enum { BCCSPLAT_MAX_CLIPS = 32 };

/* Makes the six half-spaces of a box: the points that `box_to_world`, a 4x4 row-major affine, takes
 * the cube [0, 1]^3 to. Space and instance are 0. */
BCCSPLAT_API bccsplat_status bccsplat_make_box_clips(
    const double box_to_world[16], bccsplat_clip clips[6]);
/* The matrices that a camera means, row-major, for a picture of width x height pixels with near and
 * far plane at these distances (0 < near < far; orthographic: near < far): view space has x to the
 * right, y up and looks along -z. depth_range and y_down as in bccsplat_view. */
BCCSPLAT_API bccsplat_status bccsplat_camera_get_matrices(const bccsplat_camera* camera,
    uint32_t width, uint32_t height, double near_distance, double far_distance,
    bccsplat_depth_range depth_range, uint32_t y_down, double world_to_view[16],
    double projection[16]);
/* Where n points of the world (x, y, z) are in the picture: writes n x 3 doubles, pixel
 * coordinates (the centre of pixel (i, j) is (i + 0.5, j + 0.5)) and the distance along the view
 * direction. In perspective a point that is not in front of the eye has pixel coordinates NaN. The
 * view needs a camera or matrices. width, height: size of the frame. */
BCCSPLAT_API bccsplat_status bccsplat_view_project(const bccsplat_view* view, uint32_t width,
    uint32_t height, uint64_t n, const double* xyz, double* pixels);
/* The way back. */
BCCSPLAT_API bccsplat_status bccsplat_view_unproject(const bccsplat_view* view, uint32_t width,
    uint32_t height, uint64_t n, const double* pixels, double* xyz);

/* ---- Renderer: looks, options ---- */

/* Piecewise linear in the value, constant beyond the first and last point; colour is linear RGB, 0
 * to 1e9, not premultiplied. */
typedef struct bccsplat_transfer_function {
  uint32_t struct_size;
  /* Points of 4 doubles: value, red, green, blue; values rise. */
  uint32_t color_count;
  const double* colors;
  /* Points of 2 doubles: value, opacity in [0, 1] per unit_distance; values rise. */
  const double* opacities;
  uint32_t opacity_count;
  /* 0 */
  uint32_t reserved;
  /* World length, 1e-30 to 1e30; 0: one mean voxel. */
  double unit_distance;
} bccsplat_transfer_function;

/* The box of the world (x0 y0 z0 x1 y1 z1) around the part of a slice that a transfer function
 * shows, without specks of a thousandth of it; the box of the whole slice where the function shows
 * nothing, or air. A slice of a coarser level will do. NULL: the function of
 * bccsplat_volume_get_look. Also: WRONG_STATE (a slice that misses the volume). */
BCCSPLAT_API bccsplat_status bccsplat_slice_get_seen_bounds(const bccsplat_slice* slice,
    const bccsplat_transfer_function* transfer_function, double bounds[6]);

/* Quantity that a picture shows along a ray. */
typedef int32_t bccsplat_mode;
enum {
  BCCSPLAT_MODE_DEFAULT = 0,
  /* Classified, shaded, front to back. */
  BCCSPLAT_MODE_COMPOSITE = 1,
  /* The function's colour at iso_value, opaque where a ray meets it. */
  BCCSPLAT_MODE_ISOSURFACE = 2,
  /* Line integral of the values, no transfer function. */
  BCCSPLAT_MODE_XRAY = 3,
  /* The largest value along the ray, classified. */
  BCCSPLAT_MODE_MAXIMUM = 4
};

/* How a channel is to look. */
typedef int32_t bccsplat_look_kind;
enum {
  BCCSPLAT_LOOK_DEFAULT = 0, /* by its kind */
  BCCSPLAT_LOOK_CT_BONE = 1, /* what is denser than soft tissue */
  BCCSPLAT_LOOK_CT_SOFT = 2, /* soft tissue translucent, bone in it */
  BCCSPLAT_LOOK_MR = 3,
  BCCSPLAT_LOOK_FOG = 4,
  BCCSPLAT_LOOK_FIRE = 5,
  BCCSPLAT_LOOK_SIGNED = 6, /* one colour on either side of 0, which is transparent */
  BCCSPLAT_LOOK_LABELS = 7  /* a colour for every whole number */
};

/* Kind of a channel's values, by its stored histogram. */
typedef int32_t bccsplat_data_kind;
enum {
  BCCSPLAT_KIND_EMPTY = 0,     /* nothing but air */
  BCCSPLAT_KIND_CONSTANT = 1,  /* one value beside air */
  BCCSPLAT_KIND_LABELS = 2,    /* the file says so, or few whole numbers */
  BCCSPLAT_KIND_LEVEL_SET = 3, /* distances, negative inside */
  BCCSPLAT_KIND_SIGNED = 4,    /* both sides of 0, around which most are */
  BCCSPLAT_KIND_SOLID = 5,     /* an object of values that stand apart from the background's */
  BCCSPLAT_KIND_FOG = 6,       /* values that rise from the background's without a gap */
  BCCSPLAT_KIND_DENSE = 7      /* no background: all is data */
};

/* What a first picture shows of a file. */
typedef int32_t bccsplat_layout;
enum {
  BCCSPLAT_LAYOUT_DEFAULT = 0, /* by the kind of data: as bccsplat_look.layout says */
  BCCSPLAT_LAYOUT_VOLUME = 1,
  BCCSPLAT_LAYOUT_PLANES = 2, /* three along the axes, through the middle of what is seen */
  BCCSPLAT_LAYOUT_BOTH = 3,   /* of a patient's scan: these and the volume beside them */
  BCCSPLAT_LAYOUT_FLAT = 4    /* of a map: one plane, seen from above */
};

/* A transfer function made from a channel's stored histogram: air and noise transparent, the rest
 * with an opacity by the number of voxels that a ray crosses of it. The same for all frames of a
 * series. */
typedef struct bccsplat_look {
  uint32_t struct_size;
  bccsplat_data_kind kind;
  /* Values in between are taken for air and noise; infinite where a side has no end; [0] > [1]:
   * none are. */
  double empty[2];
  /* Range that the colours span. */
  double range[2];
  /* Value of a surface between background and object. */
  double iso_value;
  /* At least 1. */
  uint32_t color_count;
  /* At least 1. */
  uint32_t opacity_count;
  /* Points as those of bccsplat_transfer_function. */
  double colors[64][4];
  /* Per mean voxel. */
  double opacities[32][2];
  /* What follows from the kind of data alone, whatever look was asked for. */
  bccsplat_layout layout;
  /* The frame that shows most: whose values span most of the range, by those that the file holds of
   * each frame, of several like it the one nearest to the middle of the series; the first that
   * there is where the file holds none. */
  uint32_t frame;
} bccsplat_look;

/* Makes a look for a channel. `look` is a BCCSPLAT_LOOK_, `mode` the BCCSPLAT_MODE_ that it is for:
 * for maximum all but air is opaque, an isosurface has one colour. Also: NOT_FOUND (channel). */
BCCSPLAT_API bccsplat_status bccsplat_volume_get_look(const bccsplat_volume* volume,
    uint32_t channel, bccsplat_look_kind look, bccsplat_mode mode, bccsplat_look* out);
/* Makes a look for a slice. A time slice gets that of its volume. Off the time axis colours and
 * opacities follow the values that the slice holds, from 0.2 to 99.8 % of those that are not air or
 * noise: a plane through the dark part of a series is no darker than a frame. Air, noise and
 * iso_value are those of the channel. Also: WRONG_STATE (a slice that misses the volume). */
BCCSPLAT_API bccsplat_status bccsplat_slice_get_look(
    const bccsplat_slice* slice, bccsplat_look_kind look, bccsplat_mode mode, bccsplat_look* out);

typedef struct bccsplat_light {
  /* Towards the light, world space, of any length from 1e-30 on; all zero: from the camera. */
  double direction[3];
  /* Linear. */
  double color[3];
} bccsplat_light;

typedef struct bccsplat_lights {
  uint32_t struct_size;
  /* 0: one white light from the camera. */
  uint32_t count;
  /* Directional, at most 8. */
  const bccsplat_light* lights;
  /* Material, as fractions of the classified colour; all four zero: 0.3 0.7 0.2 20. */
  double ambient;
  double diffuse;
  /* Strength of white highlights. */
  double specular;
  /* Up to 1e6. */
  double shininess;
  /* 1: what a light reaches of a volume is what the volume's own extinction lets through on the way
   * from it, in lit pictures of mode composite; other volumes throw no shadow on it. It is made
   * at half the resolution of the slice that is drawn, and kept while slice, transfer function and
   * lights stay; of a light from the camera along the ray of the picture's middle. UNSUPPORTED:
   * with a trail, with reference. 0: all light comes through. */
  uint32_t shadow;
  /* 1: the same of ambient light, as the mean over 14 directions around. */
  uint32_t occlusion;
} bccsplat_lights;

/* What a ray through a slice looks for. */
typedef int32_t bccsplat_pick;
enum {
  /* The first place where the field passes `threshold`, from either side. */
  BCCSPLAT_PICK_VALUE = 1,
  /* The largest value. */
  BCCSPLAT_PICK_MAXIMUM = 2,
  /* Where the opacity of the matter along the ray reaches `threshold`, above 0 and below 1. */
  BCCSPLAT_PICK_OPACITY = 3
};
/* A ray of the world; that of a pixel goes through two points of bccsplat_view_unproject. */
typedef struct bccsplat_ray {
  uint32_t struct_size;
  /* No default. */
  bccsplat_pick pick;
  double origin[3];
  /* Any length from 1e-30 on. */
  double direction[3];
  /* World distances from the origin, begin <= end, that it looks between; both 0: from the origin
   * to the end of the domain. */
  double begin;
  double end;
  double threshold;
  /* PICK_OPACITY: as a renderer's; NULL: that of bccsplat_volume_get_look. */
  const bccsplat_transfer_function* transfer_function;
} bccsplat_ray;
/* What a ray meets. */
typedef struct bccsplat_hit {
  uint32_t struct_size;
  /* 0: nothing, and all else is 0. */
  int32_t found;
  /* World, from the origin. */
  double distance;
  double world[3];
  /* In slice space. */
  double uvw[3];
  double value;
  /* Change of the value per unit of the world. */
  double gradient[3];
} bccsplat_hit;
/* Looks along a ray at the field that bccsplat_slice_evaluate gives, eight times as finely as
 * its samples; what is thinner may be missed. Holes are passed over, as is what lies outside the
 * domain. The value of labels is the one that begins there. Also: UNSUPPORTED for slices of uneven
 * axes but of BCCSPLAT_SPACE_EVEN. */
BCCSPLAT_API bccsplat_status bccsplat_slice_pick(
    const bccsplat_slice* slice, const bccsplat_ray* ray, bccsplat_hit* hit);

/* How far apart sheets are, and which gradient lights them. Errors and times of each are measured
 * in tests/bench/notes/render.md. For fields near the Nyquist rate kernel and lattice decide from
 * NORMAL on. */
typedef int32_t bccsplat_quality;
enum {
  BCCSPLAT_QUALITY_DEFAULT = 0,
  BCCSPLAT_QUALITY_DRAFT = 1,  /* sheets 1 T apart: while something moves */
  BCCSPLAT_QUALITY_NORMAL = 2, /* 0.5 T */
  BCCSPLAT_QUALITY_FINE = 3,   /* 0.25 T, for thin features */
  BCCSPLAT_QUALITY_BEST = 4    /* 0.125 T, to compare with */
};

typedef int32_t bccsplat_shading;
enum { BCCSPLAT_SHADING_DEFAULT = 0, BCCSPLAT_SHADING_OFF = 1, BCCSPLAT_SHADING_ON = 2 };

/* How the field between two sheets is drawn, in mode composite and in trails (everything else
 * ignores it). Pre-integrated, the value runs from each sheet to halfway to the next, and all that
 * the transfer function shows of the values in between is drawn: peaks, steps and bands of colour
 * narrower than that neither break up into rings nor are missed. A frame takes up to twice as long
 * (tests/bench/notes/pre-integration.md). */
typedef int32_t bccsplat_preintegrate;
enum {
  /* On where the picture of a slab changes by more than 0.15 of the function's largest: peaks of a
   * half-width below about 1.7 times the change of the values across a step, where they change
   * fast, however narrow; steps; ramps narrower than the change. Else off, bit for bit. */
  BCCSPLAT_PREINTEGRATE_DEFAULT = 0,
  /* The value on a sheet stands for half a step on either side. */
  BCCSPLAT_PREINTEGRATE_OFF = 1,
  BCCSPLAT_PREINTEGRATE_ON = 2
};

/* The edges of mode isosurface. A pixel beside which a ray meets nothing, or another surface, gets
 * the mean of four samples within it, so that its opacity is the share that the surface covers; all
 * others stay the same, bit for bit. Depth, value and time are always those at the pixel's centre.
 * Not with trails, deep frames and the reference. */
typedef int32_t bccsplat_smooth_edges;
enum {
  BCCSPLAT_SMOOTH_EDGES_DEFAULT = 0,
  BCCSPLAT_SMOOTH_EDGES_OFF = 1,
  BCCSPLAT_SMOOTH_EDGES_ON = 2
};

/* Bits of disable_skips: each switches one way of skipping work off, for tests. */
enum {
  /* Bricks invisible under the transfer function. */
  BCCSPLAT_SKIP_TRANSFER_FUNCTION = 1,
  BCCSPLAT_SKIP_FRUSTUM = 2,
  BCCSPLAT_SKIP_OCCLUSION = 4,
  BCCSPLAT_SKIP_EMPTY_SHEETS = 8,
  /* Detail finer than half a pixel: where a pixel covers 2^n .. 2^(n+1) T, n >= 1, a low-passed
   * slice of 2^n times the lattice distance is drawn (draft and normal; mode xray always, maximum
   * and trails never). */
  BCCSPLAT_SKIP_FINE_DETAIL = 16,
  /* Points of a view (slice, camera, size, options) that is drawn again under another transfer
   * function, other lights or another iso value: its second picture keeps the sheets, later ones
   * only classify them. They take at most a quarter of the memory budget; a renderer keeps those of
   * its last two views until it is given another slice. Not with trails. */
  BCCSPLAT_SKIP_UNCHANGED = 32
};
enum { BCCSPLAT_RENDER_SET_ISO = 1, BCCSPLAT_RENDER_SET_GRADIENT_NOISE = 2 };

/* One of several surfaces of mode isosurface. */
typedef struct bccsplat_iso_surface {
  double value;
  /* Fraction that it absorbs of the light that passes it once, 0 to 1; 0: it is not there. */
  double opacity;
  /* Linear RGB, where use_color is not 0; else the transfer function's at the value. */
  double color[3];
  uint32_t use_color;
  /* 0 */
  uint32_t reserved;
} bccsplat_iso_surface;
enum { BCCSPLAT_MAX_ISO_SURFACES = 16 };

/* Hears of each rectangle of the frame that is final: its pixels in all planes, the host's
 * background included, are those of the finished picture. x, y: its top left pixel. Called from any
 * thread, never two at once; a non-zero return cancels. Pixels within it may be read by pointer or
 * copied by bccsplat_frame_copy_part; PROGRESS lists the other calls that may be made. The
 * rectangles cover the picture without overlaps. Isosurfaces with smooth edges come in rows, when
 * their edges are smoothed; those of several instances, and pictures of the reference, come whole.
 * bccsplat_scene_render with a budget_ms hands over the whole frame first, as coarse as earlier
 * calls or this one have it, then each part that this call finishes. */
typedef int32_t (*bccsplat_tile_fn)(
    void* user, uint32_t x, uint32_t y, uint32_t width, uint32_t height);

typedef struct bccsplat_render_options {
  uint32_t struct_size;
  uint32_t set_mask;
  /* DEFAULT: composite. */
  bccsplat_mode mode;
  /* DEFAULT: normal; sets sheet_step and gradient unless given. */
  bccsplat_quality quality;
  /* DEFAULT: on for isosurface, and for composite but of slices that are one sample thick. */
  bccsplat_shading shading;
  uint32_t disable_skips;
  /* Distance of sheets in T; 0: by quality (draft 1, normal 0.5, fine 0.25, best 0.125; of slices
   * with corrections or masks in source samples where these are closer); 0.001 to 16, and where
   * finer than the kernel's radius / 128 as fine as that: see bccsplat_render_stats.sheet_step. */
  double sheet_step;
  /* RENDER_SET_ISO; without it and `surfaces` set_options refuses mode isosurface. */
  double iso_value;
  /* A pixel this opaque is finished: matter behind it, which could add at most the rest, is left
   * out; 0.001 to 1; 0: 0.995; 1: never, and deep pictures then hold the matter behind dense parts
   * as exactly as that in front, and up to 64 surfaces of an isosurface along each ray, without a
   * trail. */
  double opacity_stop;
  /* Non-zero: slow double-precision integration of the same field in fine steps. */
  int32_t reference;
  /* Pixels, up to 4096; 0: chosen. */
  int32_t tile_size;
  bccsplat_progress_fn progress;
  void* progress_user;
  /* FRAME_DEEP: neighbouring samples are merged while the picture cut off at any depth stays within
   * this of the one of all sheets, in opacity and in colours of up to 1; in [0, 1]; 0: 0.001. With
   * opacity_stop 1 also while it is cut off in front at any depth. The uncut picture does not
   * change. */
  double deep_tolerance;
  /* DEFAULT: where that changes a picture enough, see there. */
  bccsplat_preintegrate preintegrate;
  /* DEFAULT: on, but with quality draft. */
  bccsplat_smooth_edges smooth_edges;
  /* RENDER_SET_GRADIENT_NOISE, >= 0, in values per mean voxel. A gradient below this is treated as
   * noise: the sample is lit as if it faced every light, without highlight. A gradient three times
   * as large is that of a surface, and those between are lit by a mean of the two. 0: every
   * gradient is that of a surface. Not set: the part of a value's distance from air that the
   * kernel's ripple leaves in gradients (a tenth of it for surfaces and maxima, for composites the
   * part that differences between samples see; 0.002 to 0.004 by default, at every level alike),
   * and the noise that the file records: three standard deviations of its steps, of its
   * air_threshold and of the values of a solid object, but no more than lets an edge of three
   * voxels be lit fully. */
  double gradient_noise;
  /* NULL: none. */
  bccsplat_cancel_token* cancel_token;
  /* Mode isosurface: values and opacities, in any order, copied; composited along each ray as they
   * follow there, until opacity_stop. Depth is that of the first hit; value and time are means
   * weighted by opacity; deep pictures have a sample for each hit. A trail goes with opaque ones
   * only (render answers UNSUPPORTED). With surface_count 0 there is one, opaque, at iso_value;
   * else iso_value has no effect and needs no bit. Other modes ignore surfaces, and the log gets a
   * warning of that once per device. */
  const bccsplat_iso_surface* surfaces;
  /* At most BCCSPLAT_MAX_ISO_SURFACES. */
  uint32_t surface_count;
  /* 0 */
  uint32_t reserved;
  /* FRAME_DEPTH: the opacity at which a pixel's depth is that of its ray, 1e-6 (where something is
   * first visible) to 1 (at opacity_stop, if that is less); 0: 0.5. More than 0.5 beside FRAME_DEEP
   * with opacity_stop 1 is UNSUPPORTED. */
  double depth_opacity;
  /* NULL: none. Shows a picture as it grows. */
  bccsplat_tile_fn tile;
  void* tile_user;
  /* DEFAULT: the device's. */
  bccsplat_backend backend;
  /* 0 */
  uint32_t reserved2;
} bccsplat_render_options;

/* The part of the volume that a picture of a time slice needs. */
typedef struct bccsplat_picture_needs {
  uint32_t struct_size;
  /* The coarsest level that draws it as well as its quality asks. Draft and normal pictures: a
   * pixel covers a lattice distance of it or more, in the direction of fewest; for drafts a fifth
   * of it and for normal pictures a third is enough where the level's error, squared, is above that
   * of level 0 by at most that of 0.002 of the range (over what is kept) and nowhere above 0.05,
   * for then it is below that of the quality. 0 for fine, best and reference pictures, labels, mode
   * MAXIMUM, and where SKIP_FINE_DETAIL is switched off. */
  uint32_t level;
  /* The part of the slice that the camera sees, and three samples more, as
   * bccsplat_slice_options.box takes it; all samples where it sees nothing. */
  double box[6];
  /* 0: nothing of the slice is in the picture. */
  int32_t seen;
  int32_t reserved;
  /* Lattice distances of level 0 that a pixel covers at the centre of the domain, in the direction
   * of fewest. */
  double distances_per_pixel;
} bccsplat_picture_needs;

/* Returns the needs of a picture before the slice for it is made. Any time slice of the volume will
 * do, of the channel that is drawn: a host cuts one of the coarsest level, which costs next to
 * nothing, fits its camera to it, may draw it at once, and cuts the one that is needed. Reads
 * nothing. options may be NULL: defaults. width, height in [1, 65536]. Also: UNSUPPORTED for slices
 * that are not in time, of extracted points, or with a basis of their own. */
BCCSPLAT_API bccsplat_status bccsplat_slice_get_picture_needs(const bccsplat_slice* slice,
    const bccsplat_camera* camera, uint32_t width, uint32_t height,
    const bccsplat_render_options* options, bccsplat_picture_needs* needs);

/* The same for any view (NULL: the default one) and clips as bccsplat_renderer_set_clips takes
 * them: the box is smaller by the parts that they cut. */
BCCSPLAT_API bccsplat_status bccsplat_slice_get_view_needs(const bccsplat_slice* slice,
    const bccsplat_view* view, const bccsplat_clip* clips, uint64_t clip_count, uint32_t width,
    uint32_t height, const bccsplat_render_options* options, bccsplat_picture_needs* needs);

/* Contents of the trail. */
typedef int32_t bccsplat_trail_content;
enum {
  BCCSPLAT_TRAIL_CONTENT_DEFAULT = 0,
  /* Stills over the interval, each classified, their extinctions averaged: a thin fast object still
   * leaves a trail. */
  BCCSPLAT_TRAIL_CLASSIFIED = 1,
  /* The field's exact mean over the interval, classified once. */
  BCCSPLAT_TRAIL_MEAN = 2,
  /* Its maximum over the stills, classified once. */
  BCCSPLAT_TRAIL_MAXIMUM = 3
};

/* How trail and slice meet. */
typedef int32_t bccsplat_trail_combine;
enum {
  BCCSPLAT_TRAIL_COMBINE_DEFAULT = 0,
  /* Extinctions add along each pixel's ray; converges as sheets get thinner. */
  BCCSPLAT_TRAIL_PHYSICAL = 1,
  /* The paper's equation (8) per sheet, as printed: depends on the sheet step. An isosurface has
   * the opacity 1 on the sheet that it is hit in and on all behind it, as an object has whose
   * opacity is a threshold of the value: half of the trail there, and a half, a quarter and so on
   * of the matter behind, show through. */
  BCCSPLAT_TRAIL_INTERLEAVED = 2
};

/* 3.5D motion blur: the volume over an interval of time, drawn together with a time slice of it; or
 * the hyperplanes beside any other one, along its normal. Stills stand at the midpoints of equal
 * parts of a sub-interval (the error falls with the square of their number). Means are exact over
 * time; along other normals they are Gauss-Legendre quadratures, as fine as a lattice of the
 * source's density. */
typedef struct bccsplat_trail {
  uint32_t struct_size;
  /* DEFAULT: classified. */
  bccsplat_trail_content content;
  /* DEFAULT: physical. */
  bccsplat_trail_combine combine;
  /* Stills per sub-interval (classified, and maximum over time), up to 4096; 0: one per lattice
   * layer or index unit, 4 to 64. */
  uint32_t samples;
  /* Begin, end relative to the slice, clipped to the domain, of periodic time as
   * bccsplat_slice_options.interval, in frames. For hyperplanes off the time axis: index units
   * (voxels and frames) along the unit normal (a, b, c, d). Past [-n, 0], future [0, n], centred
   * [-n, n]; both 0: no trail, bit for bit. */
  double interval[2];
  /* Copied; NULL: the slice's. */
  const bccsplat_transfer_function* transfer_function;
  /* One linear RGB per sub-interval, instead of the function's colours; copied; NULL: with more
   * than one sub-interval of one function blue over white to orange, else, and with `weights`, the
   * function's own. */
  const double* colors;
  /* Equal sub-intervals, 1 .. 256; 0: 1. */
  uint32_t intervals;
  /* 0 */
  uint32_t reserved;
  /* `intervals` functions, one for each sub-interval from the interval's beginning on, each as long
   * as its struct_size, which all share; with their own colours unless `colors` are given; copied.
   * NULL: transfer_function for all; INVALID_ARGUMENT: both. */
  const bccsplat_transfer_function* transfer_functions;
  /* The curve of a shutter: `intervals` weights, 0 to 1e9 and not all 0, of the extinctions of the
   * sub-intervals, from the interval's beginning on, which count by their shares of the sum;
   * copied. Where they are given and `colors` are not, colours are the function's own. NULL: all
   * alike. */
  const double* weights;
  /* Non-zero: the trail is not lit, whatever the slice is. */
  uint32_t unlit;
  /* 0 */
  uint32_t reserved2;
} bccsplat_trail;

typedef struct bccsplat_render_stats {
  uint32_t struct_size;
  uint32_t threads;
  /* Moving points to the screen, summed over threads. */
  double ms_transform;
  double ms_splat;
  /* Classify, shade, composite. */
  double ms_shade;
  /* Wall. */
  double ms_total;
  /* Summed over threads. */
  double cpu_ms;
  /* Points of the slice, mirror images beyond the ends of the domain included. One opaque
   * isosurface of a time slice is drawn by rays where its lattice, kernel, field and view allow (64
   * pixels may not span half a turn or nearly so): then these are the sites without mirror images,
   * and all other counts of points and bricks 0. */
  uint64_t points_total;
  /* Points in bricks that neither their range of values nor their place left out. */
  uint64_t points_after_cull;
  /* Tile visits. */
  uint64_t points_splatted;
  /* Tile visits skipped because the pixels were finished. */
  uint64_t points_occluded;
  uint64_t tiles;
  /* Sheets of the view volume. */
  uint64_t sheets;
  /* T. */
  double sheet_step;
  /* 0: the slice itself was drawn; n: one of 2^n times its lattice distance. */
  int32_t coarse_level;
  /* 0 */
  uint32_t reserved;
  /* 1: the picture was pre-integrated. */
  int32_t preintegrated;
  /* 0 */
  uint32_t reserved2;
  /* Sheets of tiles that were kept from an earlier picture: no point was drawn. */
  uint64_t sheets_reused;
  /* Bricks of points, of the slice and a trail's stills; 0 when all sheets were kept. */
  uint64_t bricks_total;
  /* Bricks left out because nothing in them shows under the transfer function. */
  uint64_t bricks_invisible;
  /* Bricks left out because they are outside the view or the slice's box. */
  uint64_t bricks_outside;
  /* Visits of tiles to the other bricks. */
  uint64_t brick_visits;
  /* Visits skipped because the pixels of the tile around were finished. */
  uint64_t visits_hidden;
  /* Visits that were never reached: the whole tile was finished, or its rays had ended. */
  uint64_t visits_unread;
  /* Points left out in bricks that show in other places, some of them tile by tile. */
  uint64_t points_invisible;
  /* Sheets of tiles that have nothing on them. */
  uint64_t sheets_skipped;
  /* Bytes read from the file for the trail, including those of other calls at the time. */
  uint64_t bytes_read;
  /* Level of the volume that the slice is made of. */
  uint32_t level;
  /* 0 */
  uint32_t reserved3;
  /* BACKEND_CPU or BACKEND_GPU, which drew the picture. When a GPU did, the counts of points,
   * tiles, bricks and visits but points_total are 0, and ms_shade is the time of the call that
   * drew. */
  bccsplat_backend backend;
  /* 0 */
  uint32_t reserved4;
} bccsplat_render_stats;

BCCSPLAT_API bccsplat_status bccsplat_renderer_create(
    bccsplat_device* device, bccsplat_renderer** renderer);
BCCSPLAT_API void bccsplat_renderer_retain(bccsplat_renderer* renderer);
BCCSPLAT_API void bccsplat_renderer_release(bccsplat_renderer* renderer);
/* The slice to draw; retained. NULL: none. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_set_slice(
    bccsplat_renderer* renderer, const bccsplat_slice* slice);
/* Sets the trail; NULL: none. Render answers UNSUPPORTED when the mode is neither composite nor
 * isosurface, or reference is asked for. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_set_trail(
    bccsplat_renderer* renderer, const bccsplat_trail* trail);
/* Sets the camera; NULL: the default view (orthographic, rotate_x 20, rotate_y 30, fitted at
 * render). */
BCCSPLAT_API bccsplat_status bccsplat_renderer_set_camera(
    bccsplat_renderer* renderer, const bccsplat_camera* camera);
/* Sets a view: a camera or a host's matrices, a part of a picture, the host's opaque scene. It
 * replaces the camera of set_camera, and set_camera replaces it. NULL: the default view. The view's
 * camera is copied. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_set_view(
    bccsplat_renderer* renderer, const bccsplat_view* view);
/* Draws only the part of the slice that lies in all of these half-spaces of the world; at most
 * BCCSPLAT_MAX_CLIPS. They are copied. count 0: all of the slice. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_set_clips(
    bccsplat_renderer* renderer, const bccsplat_clip* clips, uint64_t count);
/* Sets the transfer function, which is copied. NULL, and before the first call: each render makes
 * the function of the slice's channel that bccsplat_volume_get_look returns for its mode
 * (LOOK_DEFAULT); several isosurfaces get that of mode composite, whose colours tell them apart. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_set_transfer_function(
    bccsplat_renderer* renderer, const bccsplat_transfer_function* function);
/* Sets lights and material, which are copied. NULL: one white light from the camera, and the
 * default material. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_set_lights(
    bccsplat_renderer* renderer, const bccsplat_lights* lights);
/* NULL: the defaults. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_set_options(
    bccsplat_renderer* renderer, const bccsplat_render_options* options);
/* Draws into every channel the frame has. A picture that is refused (INVALID_ARGUMENT, WRONG_STATE,
 * UNSUPPORTED), or that fails or is cancelled before drawing begins, such as while a trail is read,
 * leaves the frame as it was, with the deep samples, camera and attributes of the picture before.
 * One that is cancelled or fails while it is drawn keeps the tiles that were finished, and
 * elsewhere the pixels from before; the deep samples, the camera and the attributes of the frame
 * are gone then. Also: WRONG_STATE without a slice; INVALID_ARGUMENT: a camera more than 1e9 sheets
 * away, more than 1e8 sheets; UNSUPPORTED: combinations of modes, trails, deep frames and the
 * reference that cannot be drawn, such as trails and extracted points; LIMIT_EXCEEDED: more than
 * 2^32 - 1 points; for trails and levels reading. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_render(
    bccsplat_renderer* renderer, bccsplat_frame* frame);
/* Makes the render under way end with CANCELLED; may be called from any thread at any time. Between
 * renders it does nothing: a cancel token stays. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_cancel(bccsplat_renderer* renderer);
/* Returns the statistics of the last successful render. Also: WRONG_STATE before it. */
BCCSPLAT_API bccsplat_status bccsplat_renderer_get_stats(
    const bccsplat_renderer* renderer, bccsplat_render_stats* stats);

/* ---- Frame: an image ---- */

/* Channels, as bits; each a plane of float32 pixels, rows top to bottom. */
enum {
  /* 4 floats: linear premultiplied red, green, blue, opacity. Mode xray: the line integral of value
   * - air over world length in all of R, G, B; mode maximum: classified maximum. */
  BCCSPLAT_FRAME_RGBA = 1,
  /* 1 float: distance along the view direction (world) from the camera position where the opacity
   * passes 1/2, or options->depth_opacity, for isosurfaces where the first is met; infinity where
   * that never happens. */
  BCCSPLAT_FRAME_DEPTH = 2,
  /* 1 float: line integral (xray), maximum (maximum), else opacity-weighted mean value; NaN where
   * nothing is. */
  BCCSPLAT_FRAME_VALUE = 4,
  /* 1 float: opacity-weighted mean frame index; NaN where nothing is. In trails of periodic series
   * it counts on: below 0 before frame 0, above dims[3] behind the end. */
  BCCSPLAT_FRAME_TIME = 8,
  /* No plane but a list of samples per pixel, bccsplat_frame_get_deep; modes composite and
   * isosurface, no reference (render answers UNSUPPORTED). It counts
   * against the memory budget, twice while a render ends. */
  BCCSPLAT_FRAME_DEEP = 16
};

/* Samples of each pixel along its ray, as in OpenEXR's deep pictures: in order of depth that do not
 * overlap ("tidy") and, composited front to back, are the RGBA of the same render. A sample is a
 * part of the ray that absorbs evenly, or a surface (z = z_back). They are the way to composite a
 * volume with other things in depth: samples of both, in order, one over the other, a sample that
 * something divides cut by OpenEXR's rule (the part x of it absorbs 1 - (1 - opacity)^x). To take
 * samples away from the front and see those behind, ask for them with opacity_stop 1: else a ray
 * ends where it is finished, such as at the first opaque surface. */
typedef struct bccsplat_deep {
  uint32_t struct_size;
  /* Floats per sample, 6: z, z_back (as FRAME_DEPTH measures; never negative with perspective
   * cameras), opacity, premultiplied red, green, blue, all of the sample by itself. */
  uint32_t components;
  uint32_t width;
  uint32_t height;
  /* Samples of the whole picture. */
  uint64_t sample_count;
  /* width x height + 1: pixel p = y * width + x has samples first[p] .. first[p+1]-1. */
  const uint64_t* first;
  /* sample_count x components. */
  const float* samples;
} bccsplat_deep;

typedef struct bccsplat_plane {
  uint32_t struct_size;
  uint32_t components; /* floats per pixel */
  uint32_t width;
  uint32_t height;
  float* pixels; /* belongs to the frame, or is the host's own when wrapped */
  /* Bytes from one row to the next; for rows from the bottom up negative, cast to int64_t. */
  uint64_t row_bytes;
} bccsplat_plane;

typedef struct bccsplat_image_options {
  uint32_t struct_size;
  /* Non-zero: replace an existing file. */
  int32_t overwrite;
  /* PNG: non-zero: opaque over `background`; 0: transparent, straight alpha. */
  uint32_t use_background;
  uint32_t reserved;
  /* Linear RGB. */
  double background[3];
  /* EXR: frame rate of the sequence, numerator and denominator (24, 1 or 24000, 1001), both > 0,
   * written as framesPerSecond; both 0: not written. */
  int32_t frames_per_second[2];
  /* EXR: time the frame gathers, as expTime, such as a trail's length where the unit of time is
   * known; >= 0; 0: not written. */
  double exposure_seconds;
  /* EXR: UTF-8, as comments; NULL or "": not written. */
  const char* comments;
  /* NULL: none; fraction of the rows. */
  bccsplat_progress_fn progress;
  void* progress_user;
  /* NULL: none. */
  bccsplat_cancel_token* cancel_token;
} bccsplat_image_options;

/* File format of an image. */
typedef int32_t bccsplat_image;
enum { BCCSPLAT_IMAGE_PNG = 1, BCCSPLAT_IMAGE_EXR = 2, BCCSPLAT_IMAGE_DEEP_EXR = 3 };

/* width, height in [1, 65536]; channels: bits, RGBA always included. */
BCCSPLAT_API bccsplat_status bccsplat_frame_create(bccsplat_device* device, uint32_t width,
    uint32_t height, uint32_t channels, bccsplat_frame** frame);
/* An RGBA frame in the host's own memory (borrowed until release): height rows of width x 4 floats,
 * row_bytes apart (0: packed), a multiple of 4, as its address is. INVALID_ARGUMENT where all of it
 * lies in no memory. */
BCCSPLAT_API bccsplat_status bccsplat_frame_wrap(bccsplat_device* device, uint32_t width,
    uint32_t height, float* rgba, uint64_t row_bytes, bccsplat_frame** frame);
/* A plane of a frame in the host's memory: a channel's bit, and where its pixels are. */
typedef struct bccsplat_host_plane {
  uint32_t channel;
  /* 0 */
  uint32_t reserved;
  /* Row 0, at the top; borrowed until release. NULL: the frame has memory of its own for it. */
  float* pixels;
  /* From one row to the next, a multiple of 4, negative for rows from the bottom up; 0: packed. */
  int64_t row_bytes;
} bccsplat_host_plane;
/* Makes a frame of these planes, RGBA always included, in the host's memory or its own. FRAME_DEEP
 * has no plane: its pixels is NULL. INVALID_ARGUMENT: a channel twice, rows that overlap or lie in
 * no memory. */
BCCSPLAT_API bccsplat_status bccsplat_frame_wrap_planes(bccsplat_device* device, uint32_t width,
    uint32_t height, const bccsplat_host_plane* planes, uint64_t count, bccsplat_frame** frame);
/* A texture of the host's OpenGL context, in which pictures of the frame are drawn. */
typedef struct bccsplat_gl_target {
  uint32_t struct_size;
  /* GL_TEXTURE_2D, level 0, of a format that can be drawn into. Row 0 is the lowest row of the
   * picture, as OpenGL has it. Pixels are written linear, colours premultiplied by opacity. */
  uint32_t texture;
  /* In pixels, from 1 to 65536, of both textures. */
  uint32_t width;
  uint32_t height;
  /* GL_TEXTURE_2D of depths without GL_TEXTURE_COMPARE_MODE; not written. Rays end there, by the
   * matrices of the view, which it must have. 0: none. */
  uint32_t depth_texture;
  /* 0: pictures are laid over what the texture holds; 1: they replace it. */
  int32_t replace;
} bccsplat_gl_target;

/* An RGBA frame that is the host's texture: renders into it are drawn by the GPU in the OpenGL
 * context that is current on the calling thread (desktop OpenGL 3.3 or later), with nothing read
 * back, and refused where the GPU does not draw such a picture (bccsplat_gpu_info) or fails. It
 * keeps the last two slices in that context: all renders and the last release are made with it
 * current; where it is not, a render is refused (MISSING_FEATURE), and the slices are freed with
 * the context. A render leaves the context's state as it was but for errors, which are forgotten,
 * and the blending of single draw buffers. Edges are not smoothed, a view's background is not
 * looked at; with a budget_ms renders are refused. The frame has no plane in memory: nothing can be
 * saved or copied from it (NOT_FOUND, or UNSUPPORTED to save). */
BCCSPLAT_API bccsplat_status bccsplat_frame_wrap_gl(
    bccsplat_device* device, const bccsplat_gl_target* target, bccsplat_frame** frame);
BCCSPLAT_API void bccsplat_frame_retain(bccsplat_frame* frame);
BCCSPLAT_API void bccsplat_frame_release(bccsplat_frame* frame);
/* `channel` is one bit, of a plane: FRAME_DEEP has none (INVALID_ARGUMENT), but
 * bccsplat_frame_get_deep. Also: NOT_FOUND when the frame lacks it. */
BCCSPLAT_API bccsplat_status bccsplat_frame_get_channel(
    const bccsplat_frame* frame, uint32_t channel, bccsplat_plane* plane);
/* Format that pixels are copied in. */
typedef int32_t bccsplat_pixel_format;
enum {
  /* float, as the plane has them. */
  BCCSPLAT_PIXELS_F32 = 1,
  /* IEEE 754 binary16; values that are too large become infinite. */
  BCCSPLAT_PIXELS_F16 = 2,
  /* RGBA alone: bytes R G B A, colours in sRGB and not multiplied by opacity, as PNG has them. */
  BCCSPLAT_PIXELS_SRGB8 = 3,
  /* RGBA alone: the same, each colour times its opacity after coding, as windows take them. */
  BCCSPLAT_PIXELS_SRGB8_PREMULTIPLIED = 4
};
/* Copies a plane of a frame into the host's memory: `channel` is one bit; the pixels of a row lie
 * side by side, and rows are row_bytes apart, negative for rows from the bottom up (pixels then
 * points to the row at the top); 0: packed. INVALID_ARGUMENT: rows that overlap, addresses that are
 * no multiple of a number's size, bytes of other planes than RGBA. Also: NOT_FOUND when the frame
 * lacks it. */
BCCSPLAT_API bccsplat_status bccsplat_frame_copy(const bccsplat_frame* frame, uint32_t channel,
    bccsplat_pixel_format format, void* pixels, int64_t row_bytes);
/* The same of a rectangle of the frame whose top left pixel is (x, y): `pixels` is where that goes.
 * For a bccsplat_tile_fn, and on the calling thread alone. Also: INVALID_ARGUMENT beyond the
 * frame. */
BCCSPLAT_API bccsplat_status bccsplat_frame_copy_part(const bccsplat_frame* frame, uint32_t channel,
    bccsplat_pixel_format format, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
    void* pixels, int64_t row_bytes);
/* The samples of the last render into the frame; the pointers are good until the next one or the
 * last release. Also: NOT_FOUND when the frame has no FRAME_DEEP, WRONG_STATE before a render and
 * after one that was cancelled or failed on its way, which gave the samples back. */
BCCSPLAT_API bccsplat_status bccsplat_frame_get_deep(
    const bccsplat_frame* frame, bccsplat_deep* deep);
/* OpenEXR scanline file, ZIP, float: R, G, B, A unnamed first, the others as depth.Z, value.Y,
 * time.Y. The camera of the last render into the frame is written as the standard attributes
 * worldToCamera (x right, y up, z forward: left-handed), worldToNDC ((0, 0) upper left, (1, 1)
 * lower right) and, in perspective, screenWindowWidth; version, hyperplane, kernel and sheet step
 * as bccsplat/version, /hyperplane, /kernel and /sheetStep. options may be NULL. Also: writing,
 * MISSING_FEATURE. */
BCCSPLAT_API bccsplat_status bccsplat_frame_save_exr(
    const bccsplat_frame* frame, const char* path, const bccsplat_image_options* options);
/* OpenEXR deep scanline file, ZIPS, float: Z, ZBack, A, R, G, B, deepImageState tidy; attributes as
 * save_exr. Also: as there; NOT_FOUND and WRONG_STATE as bccsplat_frame_get_deep. */
BCCSPLAT_API bccsplat_status bccsplat_frame_save_deep_exr(
    const bccsplat_frame* frame, const char* path, const bccsplat_image_options* options);
/* 8-bit sRGB PNG. Also: as save_exr. */
BCCSPLAT_API bccsplat_status bccsplat_frame_save_png(
    const bccsplat_frame* frame, const char* path, const bccsplat_image_options* options);
/* The bytes of the file that save_png, save_exr or save_deep_exr would write (format:
 * BCCSPLAT_IMAGE_...), into a host's stream, which is borrowed during the call; `overwrite` has no
 * effect. Also: as they, but from writing only IO. */
BCCSPLAT_API bccsplat_status bccsplat_frame_save_stream(const bccsplat_frame* frame,
    bccsplat_image format, const bccsplat_write_stream* stream,
    const bccsplat_image_options* options);
/* The same into the host's memory: writes the first min(capacity, size) bytes; `bytes` may be NULL
 * when capacity is 0. size (may be NULL) gets the bytes in all. The image is made anew by each
 * call: 8 bytes for each pixel and 64 KiB are more than any PNG takes. Also: as they, without those
 * of writing. */
BCCSPLAT_API bccsplat_status bccsplat_frame_save_memory(const bccsplat_frame* frame,
    bccsplat_image format, const bccsplat_image_options* options, void* bytes, uint64_t capacity,
    uint64_t* size);

/* ---- Scene: volumes in a host's world ---- */

/* Volumes placed in a host's world, a time and a view. The scene picks the level and the part of
 * each volume that the view shows, reads and cuts them, keeps the slices, and draws. */
typedef struct bccsplat_scene bccsplat_scene;

/* Contents of an instance at times outside its series. */
typedef int32_t bccsplat_outside;
enum {
  BCCSPLAT_OUTSIDE_DEFAULT = 0, /* nothing */
  BCCSPLAT_OUTSIDE_HIDE = 1,
  BCCSPLAT_OUTSIDE_HOLD = 2, /* the first or last frame */
  BCCSPLAT_OUTSIDE_LOOP = 3  /* the series again: from its end it goes on with frame 0 at once */
};

/* Bits of bccsplat_instance.set_mask. */
enum { BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL = 1, BCCSPLAT_INSTANCE_SET_MASK_CHANNEL = 2 };

/* A volume, where and when it is, and how it looks. */
typedef struct bccsplat_instance {
  uint32_t struct_size;
  uint32_t channel;
  /* 4x4 row-major affine from the volume's own world to that of the scene; mirror images and
   * different scales per axis are fine. All zero: identity. */
  double placement[16];
  /* The volume shows its moment time_offset + time_scale * (time of the scene). time_scale 0: 1. */
  double time_scale;
  double time_offset;
  bccsplat_outside outside;
  /* Non-zero: it is not drawn. */
  uint32_t hidden;
  /* Copied; NULL: that of bccsplat_volume_get_look. Its unit_distance is a length of the scene's
   * world; 0: one mean voxel as it is placed. */
  const bccsplat_transfer_function* transfer_function;
  /* Factor on its extinction, up to 1e6; 0: 1. Two instances of 0.5 in one place are the volume. */
  double density;
  /* BCCSPLAT_INSTANCE_SET_...: which of the following count. */
  uint32_t set_mask;
  /* The colours are those of this channel's values, where channel absorbs or has its surface (but
   * for surfaces with a colour of their own); edges of surfaces are then not smoothed. UNSUPPORTED
   * in modes xray and maximum. */
  uint32_t color_channel;
  /* Its colours, copied; the opacities are not looked at. NULL: those of bccsplat_volume_get_look.
   */
  const bccsplat_transfer_function* color_function;
  /* What is nearest to a sample of this channel at the nearest frame whose value is none of
   * mask_labels (to within 1/2) is not drawn, in all modes; without labels nothing is. UNSUPPORTED
   * where axes are unevenly spaced. */
  uint32_t mask_channel;
  uint32_t mask_label_count;
  /* Copied. */
  const double* mask_labels;
  /* What moved around its moment, drawn with it, in the volume's own frames whatever time_scale is,
   * and with its transfer function unless the trail has one; copied. Among several instances the
   * combine of each joins its own moment and trail, and extinctions of instances add. UNSUPPORTED
   * as of a renderer, with color_channel and mask_channel.
   * NULL: none. */
  const bccsplat_trail* trail;
} bccsplat_instance;

/* Result and cost of a picture of a scene. */
typedef struct bccsplat_scene_status {
  uint32_t struct_size;
  /* 1: the frame holds the picture that was asked for; 0: a coarser one, or one in part, because
   * the budget ended. */
  uint32_t complete;
  /* Share of the work to the complete picture that is done, 0 .. 1. */
  double progress;
  /* Instances that the view shows. */
  uint32_t drawn;
  /* Slices that were cut for this picture; others were there. */
  uint32_t cut;
  /* Finest level of any volume that was drawn. */
  uint32_t level;
  uint32_t reserved;
  uint64_t bytes_read;
  /* Wall time for cutting slices, for drawing, and in all. */
  double ms_cut;
  double ms_draw;
  double ms_total;
  /* BACKEND_CPU or BACKEND_GPU, which drew. */
  bccsplat_backend backend;
  uint32_t reserved2;
} bccsplat_scene_status;

BCCSPLAT_API bccsplat_status bccsplat_scene_create(bccsplat_device* device, bccsplat_scene** scene);
BCCSPLAT_API void bccsplat_scene_retain(bccsplat_scene* scene);
BCCSPLAT_API void bccsplat_scene_release(bccsplat_scene* scene);
/* Adds a volume of the scene's device, which the scene retains; the same one may be added several
 * times. One that was opened again (bccsplat_volume_reopen) is another: it is added, and the old
 * one removed. instance NULL: the defaults. id: a number from 1 on that no instance had before.
 * Also: NOT_FOUND (channel). */
BCCSPLAT_API bccsplat_status bccsplat_scene_add(bccsplat_scene* scene,
    const bccsplat_volume* volume, const bccsplat_instance* instance, uint64_t* id);
/* Also: NOT_FOUND (id, channel). */
BCCSPLAT_API bccsplat_status bccsplat_scene_set_instance(
    bccsplat_scene* scene, uint64_t id, const bccsplat_instance* instance);
/* Also: NOT_FOUND (id). */
BCCSPLAT_API bccsplat_status bccsplat_scene_remove(bccsplat_scene* scene, uint64_t id);
/* In the unit of the volumes' times; 0 at the start. */
BCCSPLAT_API bccsplat_status bccsplat_scene_set_time(bccsplat_scene* scene, double time);
/* As bccsplat_renderer_set_clips; a clip of an instance that is gone cuts nothing. */
BCCSPLAT_API bccsplat_status bccsplat_scene_set_clips(
    bccsplat_scene* scene, const bccsplat_clip* clips, uint64_t count);
/* As bccsplat_renderer_set_lights. */
BCCSPLAT_API bccsplat_status bccsplat_scene_set_lights(
    bccsplat_scene* scene, const bccsplat_lights* lights);
/* The box of the scene's world (x0 y0 z0 x1 y1 z1) around all instances that are not hidden,
 * whatever the time; without any WRONG_STATE. */
BCCSPLAT_API bccsplat_status bccsplat_scene_get_bounds(
    const bccsplat_scene* scene, double bounds[6]);
/* As bccsplat_slice_fit_camera, so from behind, of all instances that are not hidden: that of
 * one is the camera of its time slices. From other sides by bccsplat_fit_camera with
 * bccsplat_scene_get_bounds. Also: WRONG_STATE without any. */
BCCSPLAT_API bccsplat_status bccsplat_scene_fit_camera(const bccsplat_scene* scene,
    int32_t projection, double rotate_x_degrees, double rotate_y_degrees, uint32_t width,
    uint32_t height, bccsplat_camera* camera);
/* Draws the scene at its time. view NULL: the default view of all instances (WRONG_STATE without
 * any). options NULL: the defaults, else as of a renderer; an iso value and surfaces are for all
 * instances.
 *
 * budget_ms: 0: until the picture is complete. Else about the time that the call takes: a coarse
 * picture comes first, and calls that follow with nothing changed (view, depths, options, scene) go
 * on where the last one ended, until status->complete. Cutting a slice is interrupted as well: the
 * frame then keeps its pixels, and progress is 0 until there is a first picture; where a slice
 * takes longer than the budget each call gives it twice the time of the one before. What is begun
 * is kept for one view: several views with budgets need a scene each. A complete picture is that
 * of budget 0 up to rounding, with a trail to within 2e-3. options->progress is not called, but
 * options->tile is; FRAME_DEEP is UNSUPPORTED.
 *
 * One instance in view is drawn as a renderer does. Several are drawn together, right in depth
 * where they overlap: extinctions add, and colours mix by them. In mode composite they share
 * their sheets, as far from each other as the finest lattice asks for, and take about the sum of
 * their times. In mode isosurface, or where one lattice is more than some thirty times as fine as
 * another, each takes the time of a deep picture, some three times that of a flat one, and
 * FRAME_DEEP is UNSUPPORTED. So are other modes, FRAME_VALUE and FRAME_TIME. status may be NULL.
 * Also: INVALID_ARGUMENT, UNSUPPORTED and LIMIT_EXCEEDED as bccsplat_renderer_render,
 * OUT_OF_DOMAIN (frames that a part of a series does not have), reading. */
BCCSPLAT_API bccsplat_status bccsplat_scene_render(bccsplat_scene* scene, const bccsplat_view* view,
    bccsplat_frame* frame, const bccsplat_render_options* options, double budget_ms,
    bccsplat_scene_status* status);
/* Reads all data that a picture of width x height pixels at that time will need into the volumes'
 * caches: for an idle thread of the host's, ahead of the time that it will draw. It may run while
 * other threads draw or change the scene. Also: as bccsplat_scene_render. */
BCCSPLAT_API bccsplat_status bccsplat_scene_prefetch(const bccsplat_scene* scene,
    const bccsplat_view* view, uint32_t width, uint32_t height,
    const bccsplat_render_options* options, double time);
/* The byte ranges that such a prefetch reads for one instance, of the file of its volume, whose
 * caches are empty: as bccsplat_volume_get_ranges, whose flags, ranges, capacity and count these
 * are. There are none where the instance is not seen at that time. Also: NOT_FOUND (id), as
 * bccsplat_volume_get_ranges. */
BCCSPLAT_API bccsplat_status bccsplat_scene_get_ranges(const bccsplat_scene* scene,
    const bccsplat_view* view, uint32_t width, uint32_t height,
    const bccsplat_render_options* options, double time, uint64_t id, uint32_t flags,
    uint64_t* ranges, uint64_t capacity, uint64_t* count);

#ifdef __cplusplus
}
#endif
#endif

// SPDX-License-Identifier: Apache-2.0
// A second reader of .bcc4, written from formats/bcc4.md alone and for clarity: no header of the project, no
// speed.
//
//   bcc4_dump FILE   prints what the file says about itself and, for each layer of each channel, a CRC-32 of
//   its
//                    samples: for every site, x fastest, a byte (0 air, 1 kept, 2 hole) and the relative
//                    sample as f32.
//   Exit code 1 and a message on stderr when the file breaks a rule.
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace {

using Bytes = std::vector<uint8_t>;

[[noreturn]] void refuse(const std::string& why) { throw std::runtime_error(why); }
void must(bool rule, const char* what) {
  if (!rule) refuse(what);
}

// ---- Section 1: conventions ----

struct Cursor {
  const uint8_t* at;
  const uint8_t* end;
  explicit Cursor(const Bytes& b) : at(b.data()), end(b.data() + b.size()) {}
  Cursor(const uint8_t* from, size_t n) : at(from), end(from + n) {}
  size_t left() const { return end - at; }
  const uint8_t* take(uint64_t n) {
    must(n <= left(), "bytes are missing");
    const uint8_t* p = at;
    at += n;
    return p;
  }
  uint64_t number(int bytes) {
    const uint8_t* p = take(bytes);
    uint64_t v = 0;
    for (int i = bytes; i-- > 0;) v = v << 8 | p[i];
    return v;
  }
  uint8_t u8() { return static_cast<uint8_t>(number(1)); }
  uint16_t u16() { return static_cast<uint16_t>(number(2)); }
  uint32_t u32() { return static_cast<uint32_t>(number(4)); }
  int32_t i32() { return u32(); }
  uint64_t u64() { return number(8); }
  float f32() {
    const uint32_t bits = u32();
    float v;
    std::memcpy(&v, &bits, 4);
    return v;
  }
  double f64() {
    const uint64_t bits = u64();
    double v;
    std::memcpy(&v, &bits, 8);
    return v;
  }
  std::string text() {
    const uint32_t n = u32();
    const uint8_t* p = take(n);
    const std::string s(p, p + n);
    must(s.find('\0') == std::string::npos, "text: a zero byte");
    return s;
  }
  uint64_t varint() {
    uint64_t v = 0;
    for (int i = 0; i < 10; ++i) {
      const uint8_t b = u8();
      must(i < 9 || b <= 1, "varint: too large");
      v |= static_cast<uint64_t>(b & 127) << (7 * i);
      if (b < 128) {
        must(b != 0 || i == 0, "varint: not the shortest form");
        return v;
      }
    }
    refuse("varint: too long");
  }
  void zeros(uint64_t n) {
    const uint8_t* p = take(n);
    for (uint64_t i = 0; i < n; ++i) must(p[i] == 0, "reserved bytes are not zero");
  }
};

uint32_t crc(const uint8_t* p, size_t n) { return static_cast<uint32_t>(crc32_z(0, p, n)); }

Bytes inflate_raw(const uint8_t* p, size_t n, size_t decoded) {
  Bytes out(decoded + 1); // one more, to see a stream that goes on
  z_stream z{};
  if (inflateInit2(&z, -15) != Z_OK) refuse("zlib");
  z.next_in = const_cast<uint8_t*>(p);
  z.avail_in = static_cast<uInt>(n);
  z.next_out = out.data();
  z.avail_out = static_cast<uInt>(out.size());
  const int result = inflate(&z, Z_FINISH);
  const bool whole = result == Z_STREAM_END && z.avail_in == 0 && z.total_out == decoded;
  inflateEnd(&z);
  must(whole, "deflate stream does not decode to its size");
  out.resize(decoded);
  return out;
}

struct File {
  Bytes bytes;
  uint64_t size = 0; // of the state the root tells

  const uint8_t* at(uint64_t offset, uint64_t n) const {
    must(offset % 8 == 0 && offset >= 192 && offset <= size && n <= size - offset, "bytes outside the file");
    return bytes.data() + offset;
  }
};

uint64_t padded(uint64_t n) { return (n + 7) / 8 * 8; }

struct BlockRef {
  uint64_t offset;
  uint32_t stored, decoded, check, coding;
  explicit BlockRef(Cursor& c)
      : offset(c.u64()), stored(c.u32()), decoded(c.u32()), check(c.u32()), coding(c.u32()) {}
  Bytes read(const File& f) const {
    must(coding <= 1, "block: coding");
    must(coding == 0 ? stored == decoded : stored < decoded && decoded <= 1032ull * stored, "block: sizes");
    const uint8_t* p = f.at(offset, padded(stored));
    must(crc(p, padded(stored)) == check, "block: checksum");
    Cursor(p + stored, padded(stored) - stored).zeros(padded(stored) - stored);
    return coding == 0 ? Bytes(p, p + stored) : inflate_raw(p, stored, decoded);
  }
};

// ---- Section 3: metadata ----

struct Channel {
  std::string name;
  int type = 0;
  bool linear = false; // section 12
  uint32_t air_code = 0;
  double scale = 1, offset = 0;
  float air = 0;
  uint64_t kept = 0, holes = 0;
  // Records 11 and 0x8002; shape -1: without the first.
  double step = 0, bound = 0;
  int shape = -1;
  std::optional<float> base; // of the field that is corrected
  std::vector<BlockRef> tables, frames;
  std::vector<BlockRef> masks; // by frame; empty: none
  // Record 0x800b: samples of all frames.
  struct Sums {
    uint64_t corrected, missing;
  };
  std::optional<Sums> sums;
};

// An axis of space, record 0x8009.
struct Axis {
  std::string unit;
  bool down = false;
  std::vector<double> coordinates;
};

struct Volume {
  int kind = 0, slab_layers = 0;
  uint32_t dims[4];
  int32_t last_plane[3], last_layer = 0;
  int lead = 0;
  int before[3] = {}, behind[3] = {}; // planes outside the source samples
  bool periodic = false;              // in time
  bool round[3] = {};                 // periodic along x, y, z
  double h[3], ht = 0;
  double first = 0, step = 0;
  std::vector<double> times;
  std::string spatial_unit;
  std::vector<Axis> axes; // none: without the record
  std::string recommended;
  int tile = 0; // bricks along a tile; 0: chunks are bricks
  std::vector<Channel> channels;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<Volume> levels; // coarser ones: what they share is copied

  int coset(int layer) const { return kind == 3 ? 0 : layer & 1; }
  int sites(int c, int axis) const {
    return kind == 3 ? last_plane[axis] + 1 : (last_plane[axis] - c) / 2 + 1;
  }
  int bricks(int axis) const { return (sites(0, axis) + 15) / 16; }
  int layers() const { return last_layer + 1; }
};

void check_steps(const Channel& c) {
  const double bias = std::fabs(c.offset - c.air);
  must(std::isfinite(c.air) && std::isfinite(c.scale) && std::isfinite(c.offset), "channel: not finite");
  if (c.type <= 2) {
    must(c.scale > 0 && bias <= 0x1p22 * c.scale && 65535 * c.scale + bias < 0x1p127, "channel: scale");
  } else {
    must(c.scale == 1 && (bias == 0 || (c.type == 3 && c.offset == 0)), "channel: floats have no scale");
  }
}

Channel read_channel(Cursor& c, const Volume& v) {
  Channel ch;
  ch.type = c.u8();
  must(ch.type >= 1 && ch.type <= 4, "channel: value type");
  must(c.u8() <= 9, "channel: source type");
  const int flags = c.u16();
  must(flags <= 1, "channel: flags");
  ch.linear = flags == 1;
  ch.air_code = c.u32();
  ch.scale = c.f64();
  ch.offset = c.f64();
  ch.air = c.f32();
  must(c.f32() >= 0, "channel: threshold");
  check_steps(ch);
  ch.kept = c.u64();
  ch.holes = c.u64();
  c.u64(), c.u64(); // clamped, relevant source samples
  for (int i = 0; i < 3; ++i) {
    const double low = c.f64(), high = c.f64();
    must(std::isfinite(low) && std::isfinite(high) && low <= high, "channel: range");
  }
  ch.name = c.text();
  c.text(), c.text(); // quantity, unit
  const uint32_t bins = c.u32();
  must(bins == 0 || bins == 256, "channel: histogram");
  c.take(8ull * bins);
  c.take(16ull * c.u32());
  const uint32_t frames = c.u32();
  must(frames == 0 || frames == v.dims[3], "channel: frames");
  c.take(16ull * frames);
  return ch;
}

// The steps and blocks that both records of corrections have.
void read_blocks(Cursor& r, const Volume& v, double step, std::vector<BlockRef>& blocks) {
  const uint32_t n = r.u32();
  must(n == 0 || (n == v.dims[3] && step > 0), "corrections: frames");
  for (uint32_t i = 0; i < n; ++i) blocks.emplace_back(r);
}

void read_corrections(Cursor& r, Volume& v, bool local) {
  for (Channel& c : v.channels) {
    const double step = r.f64(), bound = r.f64();
    must(std::isfinite(step) && step >= 0 && std::isfinite(bound) && bound >= 0, "corrections: step, bound");
    if (local) {
      c.shape = r.u8();
      must(c.shape <= 1, "corrections: shape");
      const uint8_t told = r.u8();
      r.zeros(2);
      const float base = r.f32();
      must(told == 1 ? std::isfinite(base) : told == 0 && base == 0 && !std::signbit(base),
           "corrections: base");
      if (told == 1) c.base = base;
    } else {
      must(c.shape < 0 || (c.step == step && c.bound == bound), "corrections: the records differ");
    }
    c.step = step, c.bound = bound;
    read_blocks(r, v, step, local ? c.tables : c.frames);
  }
}

void read_masks(Cursor& r, Volume& v) {
  for (Channel& c : v.channels) {
    const uint32_t n = r.u32();
    must(n == 0 || n == v.dims[3], "masks: frames");
    for (uint32_t i = 0; i < n; ++i) c.masks.emplace_back(r);
  }
}

void read_errors(Cursor& r, const Volume& v) {
  std::vector<uint32_t> before;
  for (uint32_t i = r.u32(); i > 0; --i) {
    const uint32_t channel = r.u32(), level = r.u32(), kind = r.u32();
    must(channel < v.channels.size() && level <= v.levels.size() && kind <= 2, "errors: what they are of");
    const std::vector<uint32_t> key{channel, level, kind};
    must(before < key, "errors: order");
    before = key;
    const uint32_t frames = r.u32();
    const auto samples = static_cast<unsigned long long>(r.u64());
    const double rmse = r.f64(), largest = r.f64(), range = r.f64();
    for (const double e : {rmse, largest, range}) must(std::isfinite(e) && e >= 0, "errors: value");
    if (level > 0) std::printf("level %u ", level);
    std::printf("error channel %u kind %u frames %u samples %llu rmse %.17g largest %.17g range %.17g\n",
                channel, kind, frames, samples, rmse, largest, range);
  }
}

// Record 8.
void read_domain(Cursor& r, Volume& v) {
  bool turns[8] = {};
  for (int end = 0; end < 8; ++end) {
    const int kind = r.u8();
    must(kind <= 3, "domain: end");
    if (kind == 2)
      turns[end] = true;
    else if (kind != 0)
      refuse("domain: this reader knows no ends but mirrors and periodic ones");
  }
  for (int a = 0; a < 4; ++a) must(turns[a] == turns[a + 4], "domain: periodic at one end");
  for (int a = 0; a < 3; ++a) v.round[a] = turns[a];
  v.periodic = turns[3];
  for (int& n : v.before) n = r.u8();
  must(r.u8() == v.lead, "domain: layers before frame 0");
  for (int& n : v.behind) n = r.u8();
  r.zeros(1);
  for (int i = 0; i < 4; ++i) must(r.f64() > 0, "domain: scales");
  must(r.left() == 0, "metadata: record too long");
}

// Record 0x800b.
void read_sums(Cursor& r, Volume& v) {
  uint64_t all = 1;
  for (const uint32_t n : v.dims) all *= n;
  for (Channel& c : v.channels) {
    const uint64_t corrected = r.u64(), missing = r.u64();
    must(corrected <= (c.tables.empty() && c.frames.empty() ? 0 : all), "sums: corrections");
    must(missing <= (c.masks.empty() ? 0 : all), "sums: missing samples");
    c.sums = {corrected, missing};
  }
  must(r.left() == 0, "sums: record too long");
}

// Record 0x8009.
void read_axes(Cursor& r, Volume& v) {
  must(v.spatial_unit.empty(), "coordinates: space has a unit");
  size_t all = 0;
  for (int a = 0; a < 3; ++a) {
    Axis axis;
    axis.unit = r.text();
    const uint32_t flags = r.u32(), n = r.u32();
    must(flags <= 1, "coordinates: flags");
    must(n == 0 || (n == v.dims[a] && n >= 2 && !v.round[a]), "coordinates: count");
    axis.down = flags == 1;
    for (uint32_t i = 0; i < n; ++i) axis.coordinates.push_back(r.f64());
    double before = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const double first = axis.coordinates.front(), last = axis.coordinates.back();
      const double even = (n - 1) * ((axis.coordinates[i] - first) / (last - first));
      must(std::isfinite(axis.coordinates[i]) && std::isfinite(last - first), "coordinates: not finite");
      must(i == 0 ? even == 0 : even > before, "coordinates: not monotone");
      before = even;
    }
    all += n;
    v.axes.push_back(axis);
  }
  must(all > 0, "coordinates: of no axis");
  must(r.left() == 0, "metadata: record too long");
}

void check_planes(const Volume& v);

// The rules of record 1 that levels have, too.
void check_layers(const Volume& v) {
  must(v.slab_layers >= 1 && v.slab_layers <= 32, "lattice");
  must((v.dims[3] == 1) == (v.ht == 0), "lattice: static or not");
  const auto near = [](double h) { return h >= 1.0 / 65536 && h <= 65536; };
  must(near(v.h[0]) && near(v.h[1]) && near(v.h[2]) && (v.ht == 0 || near(v.ht)), "lattice: distances");
  must(v.lead % 2 == 0 && (v.ht != 0 || v.lead == 0), "lattice: layers before frame 0");
  for (int a = 0; a < 3; ++a) {
    const int32_t most = v.dims[a] == 1 ? 255 : 1000000000;
    must(v.last_plane[a] >= 1 && v.last_plane[a] <= most, "lattice: planes");
  }
  must(v.last_layer >= 0 && v.last_layer <= 1000000000, "lattice: layers");
}

// How the layers fit the frames, once record 8 is known.
void check_time(const Volume& v) {
  if (!v.periodic) {
    must((v.last_layer - v.lead) * v.ht >= (v.dims[3] - 1.0) * (1 - 1e-8), "lattice: the last layer");
    must(v.ht == 0 || (v.last_layer - v.lead - 255) * v.ht <= v.dims[3],
         "lattice: layers behind the last frame");
    return;
  }
  must(v.dims[3] > 1 && v.lead == 0 && (v.kind == 3 || v.layers() % 2 == 0), "lattice: periodic");
  must(std::fabs(v.layers() * v.ht - v.dims[3]) <= 1e-9 * v.dims[3], "lattice: a turn");
}

// Record 9.
void read_levels(Cursor& r, Volume& v) {
  const uint32_t n = r.u32();
  must(n >= 1 && n <= 15, "levels: count");
  for (uint32_t i = 0; i < n; ++i) {
    Volume level = v;
    level.levels.clear();
    level.slab_layers = r.u8();
    r.zeros(3);
    for (int& b : level.before) b = r.u8();
    level.lead = r.u8();
    for (int& b : level.behind) b = r.u8();
    r.zeros(1);
    for (int32_t& l : level.last_plane) l = r.i32();
    level.last_layer = r.i32();
    r.zeros(4);
    for (double& d : level.h) d = r.f64();
    level.ht = r.f64();
    check_layers(level);
    check_time(level);
    check_planes(level);
    const Volume& finer = i == 0 ? v : v.levels.back();
    for (int a = 0; a < 3; ++a)
      must(std::isfinite(level.h[a]) && level.h[a] > 0 && (v.dims[a] == 1 || level.h[a] >= finer.h[a]),
           "levels: planes closer than before");
    must(level.ht >= finer.ht, "levels: layers closer than before");
    v.levels.push_back(level);
  }
  for (Volume& level : v.levels)
    for (Channel& c : level.channels) {
      must(r.f64() == c.scale, "levels: scale");
      c.kept = r.u64(), c.holes = r.u64();
      r.u64(); // clamped
      const double low = r.f64(), high = r.f64();
      must(std::isfinite(low) && std::isfinite(high) && low <= high, "levels: range");
    }
  must(r.left() == 0, "metadata: record too long");
}

// The planes between the outermost source samples reach from one to the other.
void check_planes(const Volume& v) {
  for (int a = 0; a < 3; ++a) {
    const double end = v.dims[a] - (v.round[a] ? 0.0 : 1.0);
    const int outside = v.before[a] + v.behind[a], inside = v.last_plane[a] + v.round[a] - outside;
    must(!v.round[a] || (v.dims[a] > 1 && outside == 0 && (v.kind == 3 || inside % 2 == 0)),
         "domain: a periodic axis");
    must(v.kind == 3 || v.before[a] % 2 == 0, "domain: an odd number of planes before the first sample");
    must(inside >= 1 && (end > 0 || outside == 0), "domain: no planes inside");
    must(end == 0 || std::fabs(inside * v.h[a] - end) <= 1e-9 * end,
         "lattice: the end of the domain has no plane");
  }
}

// Record 13.
void read_tiles(Cursor& r, Volume& v) {
  v.tile = r.u8();
  must(v.tile == 2 || v.tile == 4 || v.tile == 8, "tiles: bricks along an axis");
  r.zeros(7);
  for (const Channel& c : v.channels) {
    const double error = r.f64();
    must(std::isfinite(error) && error > 0, "tiles: error");
    must(c.type <= 2, "tiles: value type");
  }
  for (Volume& level : v.levels) level.tile = v.tile;
  must(r.left() == 0, "metadata: record too long");
}

Volume read_metadata(const Bytes& bytes) {
  Volume v;
  Cursor c(bytes);
  int last = 0;
  bool seen[8] = {};
  while (c.left() > 0) {
    const int type = c.u16();
    c.zeros(2);
    const uint32_t n = c.u32();
    Cursor r(c.take(n), n);
    c.zeros(padded(n) - n);
    must(type > last || (type == last && type == 5), "metadata: order of records");
    last = type;
    if (type == 0x8007) {
      const int64_t slabs = r.i32();
      must(slabs >= 0 && slabs * v.slab_layers < v.layers() + v.slab_layers, "counts: slabs");
      r.take(r.u32());
      must(r.left() == 0, "counts: record too long");
      continue;
    }
    if (type == 8) {
      read_domain(r, v);
      continue;
    }
    if (type == 9) {
      read_levels(r, v);
      continue;
    }
    if (type == 10) {
      read_masks(r, v);
      must(r.left() == 0, "metadata: record too long");
      continue;
    }
    if (type == 11 || type == 0x8002 || type == 0x8005) {
      if (type == 0x8005)
        read_errors(r, v);
      else
        read_corrections(r, v, type == 11);
      must(r.left() == 0, "metadata: record too long");
      continue;
    }
    if (type == 13) {
      read_tiles(r, v);
      continue;
    }
    if (type == 0x8009) read_axes(r, v);
    if (type == 0x800b) read_sums(r, v);
    if (type >= 0x8000) continue;
    must(type != 12, "metadata: this reader knows no stencils");
    must(type >= 1 && type <= 7, "metadata: unknown record");
    seen[type] = true;
    if (type == 1) {
      v.kind = r.u8();
      v.slab_layers = r.u8();
      v.lead = r.u8();
      r.zeros(1);
      for (uint32_t& d : v.dims) d = r.u32();
      for (int32_t& l : v.last_plane) l = r.i32();
      v.last_layer = r.i32();
      r.zeros(4);
      for (double& d : v.h) d = r.f64();
      v.ht = r.f64();
      r.f64(), r.f64(); // scale, time scale
      must(v.kind >= 1 && v.kind <= 3, "lattice");
      check_layers(v);
    } else if (type == 2) {
      for (int i = 0; i < 12; ++i) must(std::isfinite(r.f64()), "world");
      v.spatial_unit = r.text();
    } else if (type == 3) {
      v.first = r.f64();
      v.step = r.f64();
      r.text(), r.text(); // unit, epoch
      const uint32_t count = r.u32();
      must(count == 0 || count == v.dims[3], "time: count");
      for (uint32_t i = 0; i < count; ++i) v.times.push_back(r.f64());
    } else if (type == 4) {
      v.recommended = r.text();
    } else if (type == 5) {
      v.channels.push_back(read_channel(r, v));
    } else if (type == 6) {
      for (uint32_t i = r.u32(); i > 0; --i) r.text(), r.u64(), r.u32();
    } else {
      for (uint32_t i = r.u32(); i > 0; --i) {
        const std::string key = r.text();
        v.attributes.emplace_back(key, r.text());
      }
    }
    must(r.left() == 0, "metadata: record too long");
  }
  for (int type = 1; type <= 7; ++type) must(seen[type], "metadata: a record is missing");
  check_time(v);
  check_planes(v);
  return v;
}

// ---- Section 4: index ----

struct Chunk {
  uint32_t slab, slot, values, runs, runs_decoded, kept, holes, smallest, largest, check;
  uint64_t offset;
  int coding, predictor;
  uint64_t end() const { return offset + padded(uint64_t{values} + runs); }
};

std::vector<Chunk> read_page(const Bytes& bytes) {
  Cursor c(bytes);
  const uint32_t n = c.u32(), k = c.u32();
  must(n >= 1 && n <= 65536 && k <= 256, "page");
  std::vector<std::pair<int, int>> columns;
  for (uint32_t i = 0; i < k; ++i) {
    const int id = c.u8(), width = c.u8();
    c.zeros(2);
    columns.emplace_back(id, width);
  }
  std::map<int, std::vector<uint64_t>> column;
  for (const auto& [id, width] : columns) {
    const uint8_t* p = c.take(uint64_t{n} * width);
    if (id >= 128) continue;
    auto& values = column[id];
    values.resize(n);
    for (int b = 0; b < width; ++b)
      for (uint32_t i = 0; i < n; ++i)
        values[i] |= static_cast<uint64_t>(p[static_cast<uint64_t>(b) * n + i]) << (8 * b);
  }
  must(c.left() == 0, "page: too long");
  for (int id = 1; id <= 13; ++id) must(column.count(id) == 1, "page: a column is missing");
  must(column.size() == 13, "page: unknown column");
  std::vector<Chunk> chunks(n);
  Chunk before{};
  for (uint32_t i = 0; i < n; ++i) {
    Chunk& e = chunks[i];
    const auto get = [&](int id) { return static_cast<uint32_t>(column[id][i]); };
    e.slab = before.slab + get(1);
    e.slot = before.slot + get(2);
    e.values = get(3), e.runs = get(4);
    e.offset = before.end() + column[5][i];
    e.runs_decoded = get(6), e.kept = get(7), e.holes = get(8);
    e.smallest = get(9), e.largest = get(10), e.check = get(11);
    e.coding = get(12), e.predictor = get(13);
    must(e.smallest <= e.largest, "page: smallest and largest sample");
    before = e;
  }
  return chunks;
}

// ---- Sections 5 to 7: chunks ----

struct Box {
  int nx, ny, nz;
};

// The state of every site in order: true where a run sets it.
std::vector<bool> read_runs(Cursor& c, uint64_t sites, uint64_t set) {
  std::vector<bool> bits(sites);
  uint64_t at = 0, found = 0;
  while (found < set) {
    const uint64_t skip = c.varint(), run = c.varint();
    must(run > 0 && (skip > 0 || found == 0), "run list: not canonical");
    must(skip <= sites - at && run <= sites - at - skip && run <= set - found, "run list: too long");
    at += skip;
    for (uint64_t i = 0; i < run; ++i) bits[at++] = true;
    found += run;
  }
  return bits;
}

// Cells of one layer, section 7.
struct Cells {
  std::vector<int64_t> g = std::vector<int64_t>(18 * 18 * 18);
  int64_t& at(int x, int y, int z) { return g[((z + 1) * 18 + y + 1) * 18 + x + 1]; }
  int64_t get(int x, int y, int z) const { return g[((z + 1) * 18 + y + 1) * 18 + x + 1]; }
  void copy_row(int y, int z, int from_y, int from_z) {
    for (int x = -1; x <= 16; ++x) at(x, y, z) = get(x, from_y, from_z);
  }
  void copy_plane(int z, const Cells& other, int from_z) {
    for (int y = -1; y <= 16; ++y)
      for (int x = -1; x <= 16; ++x) at(x, y, z) = other.get(x, y, from_z);
  }
};

const int own_taps[10][3] = {{-1, 0, 0},  {0, -1, 0},   {0, 0, -1}, {-1, -1, 0}, {-1, 0, -1},
                             {0, -1, -1}, {-1, -1, -1}, {1, -1, 0}, {1, 0, -1},  {0, 1, -1}};
const int previous_taps[7][3] = {{0, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0},
                                 {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};

struct Weights {
  int own[10] = {}, cross[8] = {}, previous[7] = {};
};

Weights fixed_weights(int predictor, bool has_cross, bool has_previous) {
  Weights w;
  const auto all_cross = [&] {
    for (int& x : w.cross) x = 512;
  };
  if (predictor == 2) {
    const int lorenzo[7] = {4096, 4096, 4096, -4096, -4096, -4096, 4096};
    std::copy(lorenzo, lorenzo + 7, w.own);
  } else if (predictor == 3 && has_previous) {
    w.previous[0] = 4096;
  } else if ((predictor == 3 || predictor == 4) && has_cross) {
    all_cross();
  } else if (predictor == 4 && has_previous) {
    w.previous[0] = 4096;
  } else {
    w.own[0] = 4096;
  }
  return w;
}

// How the samples of a channel are coded, section 6.
struct Coding {
  size_t width = 0;
  bool floats = false;
  int64_t air = 0; // code of air
  uint64_t top() const { return (uint64_t{1} << (8 * width)) - 1; }
};

Coding coding_of(const Channel& ch) {
  const size_t widths[4] = {1, 2, 2, 4};
  return {widths[ch.type - 1], ch.type >= 3, ch.air_code};
}

struct Decoded {
  std::vector<std::vector<uint8_t>> state; // per layer: 4096 of 0, 1, 2
  std::vector<std::vector<uint32_t>> code; // per layer: 4096 ordered codes
  std::vector<std::vector<float>> sample;  // of a linear channel 4096 samples, relative to air
};

// The bytes of a chunk, all but the zeros.
const uint8_t* chunk_bytes(const File& f, const Chunk& e) {
  const uint64_t size = e.end() - e.offset;
  const uint8_t* p = f.at(e.offset, size);
  must(crc(p, size) == e.check, "chunk: checksum");
  Cursor(p + e.values + e.runs, size - e.values - e.runs).zeros(size - e.values - e.runs);
  return p;
}

// A brick in the layers of a slab: its sites inside the domain.
struct Brick {
  int at[3];
  std::vector<Box> layers;
  uint64_t sites = 0;
  Brick(const Volume& v, uint32_t slab, int x, int y, int z) : at{x, y, z} {
    const int first_layer = static_cast<int>(slab) * v.slab_layers;
    for (int m = first_layer; m < std::min(first_layer + v.slab_layers, v.layers()); ++m) {
      int n[3];
      for (int a = 0; a < 3; ++a) n[a] = std::max(0, std::min(16, v.sites(v.coset(m), a) - 16 * at[a]));
      if (n[0] == 0 || n[1] == 0 || n[2] == 0) n[0] = n[1] = n[2] = 0;
      layers.push_back({n[0], n[1], n[2]});
      sites += n[0] * n[1] * n[2];
    }
  }
};

// Section 5: the sites of a chunk that are kept, and which of these are holes.
struct Kept {
  std::vector<bool> kept, hole;
};

Kept read_kept(const uint8_t* p, const Chunk& e, uint64_t sites) {
  const int runs_coding = e.coding >> 4;
  must(runs_coding <= 1, "chunk: coding");
  must(e.kept >= 1 && e.kept <= sites && e.holes <= e.kept, "chunk: counts");
  must(runs_coding == 0 ? e.runs == e.runs_decoded : e.runs < e.runs_decoded, "chunk: runs");
  const Bytes runs = runs_coding == 0 ? Bytes(p + e.values, p + e.values + e.runs)
                                      : inflate_raw(p + e.values, e.runs, e.runs_decoded);
  Cursor c(runs);
  Kept k;
  k.kept = read_runs(c, sites, e.kept);
  k.hole = read_runs(c, e.kept, e.holes);
  must(c.left() == 0, "chunk: bytes behind the run lists");
  return k;
}

Decoded decode(const File& f, const Volume& v, const Channel& ch, const Chunk& e) {
  const uint8_t* p = chunk_bytes(f, e);
  const int first_layer = static_cast<int>(e.slab) * v.slab_layers;
  const Brick brick(v, e.slab, static_cast<int>(e.slot) % v.bricks(0),
                    static_cast<int>(e.slot) / v.bricks(0) % v.bricks(1),
                    static_cast<int>(e.slot) / v.bricks(0) / v.bricks(1));
  const std::vector<Box>& box = brick.layers;
  const int layers = static_cast<int>(box.size());
  const int values_coding = e.coding & 15;
  must(values_coding <= 1 && e.predictor <= 5, "chunk: coding");
  const auto [kept, hole] = read_kept(p, e, brick.sites);

  // Which classes of layers there are, and their weights.
  const int period = v.kind == 3 ? 1 : 2;
  const auto has_cross = [&](int m) { return v.kind != 3 && m >= 1 && box[m - 1].nx > 0; };
  const auto has_previous = [&](int m) { return v.ht != 0 && m >= period; };
  const auto class_of = [&](int m) { return (has_cross(m) ? 1 : 0) + (has_previous(m) ? 2 : 0); };
  bool present[4] = {};
  for (int m = 0; m < layers; ++m)
    if (box[m].nx > 0) present[class_of(m)] = true;
  size_t weight_count = 0;
  for (int k = 0; k < 4; ++k)
    if (present[k] && e.predictor == 5) weight_count += 10u + (k & 1 ? 8u : 0u) + (k & 2 ? 7u : 0u);

  // Section 7.
  const Coding coding = coding_of(ch);
  const size_t width = coding.width;
  const uint64_t top = coding.top();
  must(values_coding == 0 ? e.values == e.kept * width && e.predictor == 0 : e.values < e.kept * width,
       "chunk: values");
  const size_t decoded_size = 2 * weight_count + e.kept * width;
  const Bytes values = values_coding == 0 ? Bytes(p, p + e.values) : inflate_raw(p, e.values, decoded_size);
  Cursor vc(values);
  Weights weights[4];
  for (int k = 0; k < 4; ++k) {
    weights[k] = fixed_weights(e.predictor, k & 1, k & 2);
    if (e.predictor != 5 || !present[k]) continue;
    weights[k] = Weights();
    int sum = 0;
    const auto next = [&] {
      const int w = static_cast<int16_t>(vc.u16());
      sum += w < 0 ? -w : w;
      return w;
    };
    for (int& w : weights[k].own) w = next();
    if (k & 1)
      for (int& w : weights[k].cross) w = next();
    if (k & 2)
      for (int& w : weights[k].previous) w = next();
    must(sum <= 32767, "chunk: weights");
  }
  const uint8_t* planes = vc.at;
  const auto stored = [&](size_t i) { // pattern or residual of the i-th kept site
    uint64_t r = 0;
    for (size_t byte = 0; byte < width; ++byte)
      r |= static_cast<uint64_t>(values_coding == 0 ? planes[i * width + byte] : planes[byte * e.kept + i])
           << (8 * byte);
    return r;
  };

  Decoded out;
  std::vector<Cells> cells(static_cast<size_t>(layers));
  size_t site = 0, value = 0;
  uint64_t smallest = UINT64_MAX, largest = 0;
  for (int m = 0; m < layers; ++m) {
    out.state.emplace_back(4096);
    out.code.emplace_back(4096);
    const auto [nx, ny, nz] = box[m];
    if (nx == 0) continue;
    Cells& own = cells[m];
    const Cells* previous = has_previous(m) ? &cells[m - period] : nullptr;
    const Cells* cross = has_cross(m) ? &cells[m - 1] : nullptr;
    const Weights& w = weights[class_of(m)];
    const int shift = v.coset(first_layer + m) == 1 ? 0 : -1;
    const Cells* before = previous ? previous : cross;
    if (before)
      for (int z = -1; z <= nz; ++z)
        for (int y = -1; y <= ny; ++y)
          for (int x = -1; x <= nx; ++x)
            if (x < 0 || y < 0 || z < 0 || x == nx || y == ny || z == nz)
              own.at(x, y, z) = before->get(x, y, z);
    for (int z = 0; z < nz; ++z) {
      if (!before && z > 0) own.copy_row(-1, z, 0, z - 1);
      for (int y = 0; y < ny; ++y) {
        if (!before) own.at(-1, y, z) = own.get(0, y - 1, z);
        for (int x = 0; x < nx; ++x) {
          if (!kept[site++]) continue;
          const size_t index = (z * 16 + y) * 16 + x;
          out.state.back()[index] = hole[value] ? 2 : 1;
          uint64_t code = stored(value++);
          if (values_coding == 0) { // a pattern
            if (coding.floats) code = code > top / 2 ? top - code : code + top / 2 + 1;
          } else if (e.predictor != 0) {
            int64_t sum = 2048;
            for (int t = 0; t < 10; ++t)
              sum += w.own[t] * own.get(x + own_taps[t][0], y + own_taps[t][1], z + own_taps[t][2]);
            if (cross)
              for (int t = 0; t < 8; ++t)
                sum += w.cross[t] *
                       cross->get(x + shift + (t & 1), y + shift + (t >> 1 & 1), z + shift + (t >> 2));
            if (previous)
              for (int t = 0; t < 7; ++t)
                sum += w.previous[t] * previous->get(x + previous_taps[t][0], y + previous_taps[t][1],
                                                     z + previous_taps[t][2]);
            const int64_t quotient = sum >= 0 ? sum / 4096 : -((-sum + 4095) / 4096);
            const int64_t unclamped = coding.air + quotient;
            const uint64_t prediction = unclamped < 0 ? 0
                                        : unclamped > static_cast<int64_t>(top)
                                            ? top
                                            : static_cast<uint64_t>(unclamped);
            const uint64_t d = code % 2 == 0 ? code / 2 : top - (code - 1) / 2;
            code = (prediction + d) % (top + 1);
          }
          out.code.back()[index] = static_cast<uint32_t>(code);
          smallest = std::min(smallest, code), largest = std::max(largest, code);
          own.at(x, y, z) = static_cast<int64_t>(code) - coding.air;
        }
        own.at(nx, y, z) = own.get(nx - 1, y, z);
      }
      own.copy_row(ny, z, ny - 1, z);
    }
    for (int z = 0; z < nz; ++z) {
      for (int y = 0; y < ny; ++y) own.at(-1, y, z) = own.get(0, y, z);
      own.copy_row(-1, z, 0, z);
      own.copy_row(ny, z, ny - 1, z);
    }
    own.copy_plane(-1, own, 0);
    own.copy_plane(nz, own, nz - 1);
  }
  must(smallest == e.smallest && largest == e.largest, "chunk: smallest and largest sample");
  return out;
}

// ---- Section 12: tiles ----

int bits_of(int64_t v) {
  int n = 0;
  for (; v > 0; v /= 2) ++n;
  return n;
}

int64_t floor_div(int64_t a, int64_t b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

// Contexts: the coefficients of a band, in steps.
struct Band {
  int level = 0, d = 0; // of the rest 0
  int layers = 0, from[3] = {}, size[3] = {};
  std::vector<int> steps;
  const Band* parent = nullptr;
  int halved = 0; // axes along which the parent's level halves

  size_t index(int k, int z, int y, int x) const { return ((k * size[2] + z) * size[1] + y) * size[0] + x; }
  int m(int k, int z, int y, int x) const {
    if (k < 0 || k >= layers || z < 0 || z >= size[2] || y < 0 || y >= size[1] || x < 0 || x >= size[0])
      return 0;
    return std::min(std::abs(steps[index(k, z, y, x)]), 1023);
  }
  // Those beside a place in a layer.
  int cross(int k, int z, int y, int x) const {
    return m(k, z, y, x - 1) + m(k, z, y, x + 1) + m(k, z, y - 1, x) + m(k, z, y + 1, x);
  }
  int beside(int k, int z, int y, int x) const {
    return cross(k, z, y, x) + m(k, z - 1, y, x) + m(k, z + 1, y, x);
  }
  int of_parent(int k, int z, int y, int x) const {
    return parent ? parent->m(k, z >> (halved >> 2 & 1), y >> (halved >> 1 & 1), x >> (halved & 1)) : 0;
  }
  int beside_parent(int k, int z, int y, int x) const {
    return parent ? parent->beside(k, z >> (halved >> 2 & 1), y >> (halved >> 1 & 1), x >> (halved & 1)) : 0;
  }
};

// The box of a coset in a tile.
struct TileBox {
  int n[3] = {}, layers = 0;
  int h[3] = {}, levels = 0;          // halvings of the axes, the largest of them
  std::vector<std::vector<int>> time; // row k, column t
  std::vector<Band> bands;
  std::vector<std::vector<float>> samples; // by layer

  int kept(int a, int l) const {
    const int parts = 1 << std::min(l, h[a]);
    return (n[a] + parts - 1) / parts;
  }
  int halved(int l) const { // axes, as the bits of a direction
    return (h[0] >= l ? 1 : 0) + (h[1] >= l ? 2 : 0) + (h[2] >= l ? 4 : 0);
  }
  float& at(int t, int z, int y, int x) { return samples[t][(z * n[1] + y) * n[0] + x]; }
};

std::vector<std::vector<int>> cosines(int n) {
  std::vector<std::vector<int>> rows(n, std::vector<int>(n));
  const double pi = 3.14159265358979323846;
  for (int k = 0; k < n; ++k)
    for (int t = 0; t < n; ++t)
      rows[k][t] = static_cast<int>(
          std::lround(std::sqrt((k > 0 ? 2.0 : 1.0) / n) * std::cos(pi * k * (t + 0.5) / n) * 16384));
  return rows;
}

// Bands, in the order in which they are coded. The rest has direction 0.
void add_band(TileBox& box, int l, int d) {
  Band b;
  b.level = d == 0 ? 0 : l, b.d = d, b.layers = box.layers;
  for (int a = 0; a < 3; ++a) {
    const bool upper = d >> a & 1;
    b.from[a] = upper ? box.kept(a, l) : 0;
    b.size[a] = upper ? box.kept(a, l - 1) - box.kept(a, l) : box.kept(a, l);
  }
  b.steps.resize(b.layers * b.size[0] * b.size[1] * b.size[2]);
  if (!b.steps.empty()) box.bands.push_back(b);
}

void make_bands(TileBox& box) {
  add_band(box, box.levels, 0);
  for (int l = box.levels; l >= 1; --l)
    for (int d = 1; d <= 7; ++d)
      if ((d & box.halved(l)) == d) add_band(box, l, d);
  for (Band& b : box.bands) {
    if (b.d == 0) continue;
    b.halved = box.halved(b.level + 1);
    for (const Band& other : box.bands)
      if (other.d > 0 && other.level == b.level + 1 && other.d == (b.d & b.halved)) b.parent = &other;
  }
}

// The expected magnitude, in 1/64, without what its own row adds.
int64_t expected_above(const std::vector<Band>& bands, size_t which, int k, int z, int y, int x) {
  const Band& b = bands[which];
  int64_t s = 12 * b.m(k, z, y - 1, x) + 8 * b.m(k, z - 1, y, x);
  s += 3 * (b.m(k, z, y - 2, x) + b.m(k, z - 2, y, x));
  s += 4 * (b.m(k, z, y - 1, x - 1) + b.m(k, z, y - 1, x + 1));
  s += 2 * b.cross(k, z - 1, y, x);
  s += 8 * b.m(k - 1, z, y, x) + 4 * b.m(k - 2, z, y, x);
  s += b.beside(k - 1, z, y, x);
  s += 6 * b.of_parent(k, z, y, x) + b.beside_parent(k, z, y, x);
  for (size_t i = 0; i < which; ++i)
    if (b.d > 0 && bands[i].d > 0 && bands[i].level == b.level) s += 6 * bands[i].m(k, z, y, x);
  return s;
}

int64_t expected(const std::vector<Band>& bands, size_t which, int k, int z, int y, int x) {
  const Band& b = bands[which];
  return 12 * b.m(k, z, y, x - 1) + 4 * b.m(k, z, y, x - 2) + expected_above(bands, which, k, z, y, x);
}

int bucket_of(int64_t s) {
  if (s < 4) return static_cast<int>(s);
  const int o = bits_of(s) - 3;
  return static_cast<int>(std::min<int64_t>(63, 4 * o + (s >> o)));
}

int near_of(const Band& b, int k, int z, int y, int x) {
  int near = std::min(b.m(k, z, y, x - 1), 3);
  for (const int m : {b.m(k, z, y - 1, x), b.m(k, z - 1, y, x), b.m(k - 1, z, y, x), b.of_parent(k, z, y, x)})
    near = 3 * near + std::min(m, 2);
  return near;
}

// Probabilities.
struct Context {
  int p = 32768, count = 0;
  void learn(bool bit) {
    p += static_cast<int>(floor_div(((bit ? 65535ll : 0) - p) * (327680 / (10 * count + 16)), 1 << 15));
    count = std::min(count + 1, 255);
  }
};

Context first_guess(int j, int64_t least) {
  const int64_t typical = j < 4 ? 10 * j + 3 : int64_t{45 + 10 * (j % 4)} << (j / 4 - 1);
  const int64_t e = std::max(least, typical);
  return {static_cast<int>(std::clamp<int64_t>(65536 * e / (640 + e), 64, 65000)), 3};
}

// Mixing: P of all logits, from -2304 on.
std::vector<int> logistic() {
  const int knots[37] = {32768, 36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287,
                         60565, 61598, 62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974,
                         65097, 65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489,
                         65500, 65508, 65514, 65519, 65523, 65526, 65528};
  std::vector<int> all(2 * 2304 + 1);
  for (int l = 0; l <= 2304; ++l) {
    const int j = l / 64, r = l % 64;
    const int p = r == 0 ? knots[j] : (knots[j] * (64 - r) + knots[j + 1] * r + 32) / 64;
    all[2304 + l] = std::clamp(p, 6, 65530);
    all[2304 - l] = std::clamp(65536 - p, 6, 65530);
  }
  return all;
}
const std::vector<int> all_p = logistic();

int64_t logit(int p) {
  const auto found = std::lower_bound(all_p.begin(), all_p.end(), p / 16 * 16 + 8);
  return std::min<int64_t>(found - all_p.begin(), 2 * 2304) - 2304;
}

// The arithmetic decoder.
struct BitReader {
  Cursor rest;
  uint32_t low = 0, high = 0xffffffff, value = 0;
  explicit BitReader(const Cursor& stream) : rest(stream) {
    for (int i = 0; i < 4; ++i) value = value << 8 | next();
  }
  uint32_t next() { return rest.left() > 0 ? rest.u8() : 0; }
  bool bit(int p) {
    const uint32_t middle = low + static_cast<uint32_t>(uint64_t{high - low} * p >> 16);
    const bool set = value <= middle;
    if (set)
      high = middle;
    else
      low = middle + 1;
    while (low >> 24 == high >> 24) low <<= 8, high = high << 8 | 255, value = value << 8 | next();
    return set;
  }
};

// Bits: the coefficients of a tile. Contexts and mixers are those of the whole tile, by what the page names.
struct Coefficients {
  using Key = std::tuple<int, int, int, int>;
  BitReader in;
  std::map<Key, Context> row, zero, zero_layer, zero_near, more, more_near, digits;
  std::map<Key, std::vector<int64_t>> zero_mixer, more_mixer;

  explicit Coefficients(const Cursor& stream) : in(stream) {}

  bool alone(Context& c) {
    const bool bit = in.bit(std::clamp(c.p, 16, 65520));
    c.learn(bit);
    return bit;
  }

  bool mixed(std::vector<int64_t>& weights, const std::vector<Context*>& contexts) {
    const size_t n = contexts.size();
    if (weights.empty()) weights.assign(n, 21845 / static_cast<int64_t>(n));
    std::vector<int64_t> logits;
    int64_t sum = 0;
    for (size_t i = 0; i < n; ++i) {
      logits.push_back(logit(contexts[i]->p));
      sum += weights[i] * logits[i];
    }
    const int p = all_p[std::clamp<int64_t>(floor_div(sum, 1 << 14), -2304, 2304) + 2304];
    const bool bit = in.bit(p);
    const int64_t error = (bit ? 65535 : 0) - p;
    for (size_t i = 0; i < n; ++i) {
      const int64_t w = weights[i] + floor_div(logits[i] * error + (1 << 17), 1 << 18);
      weights[i] = std::clamp<int64_t>(w, -(1 << 17), 1 << 17);
      contexts[i]->learn(bit);
    }
    return bit;
  }

  // What is behind 13 bits that are set.
  int large_magnitude() {
    int b = 0;
    while (b < 20 && alone(digits[{b, 0, 0, 0}])) ++b;
    int v = 1;
    for (int i = 0; i < b; ++i) v = 2 * v + (in.bit(32768) ? 1 : 0);
    return v - 1 + 14;
  }

  int coefficient(const Band& b, int k, int bucket, int near) {
    const int quarter = bucket / 4, rest = b.d == 0 ? 1 : 0;
    Context& c0 = zero.try_emplace({b.level, bucket, 0, 0}, first_guess(bucket, 0)).first->second;
    Context& c1 =
        zero_layer.try_emplace({b.level, b.d, k, quarter}, first_guess(4 * quarter + 2, 0)).first->second;
    if (!mixed(zero_mixer[{b.level, bucket, 0, 0}], {&c0, &c1, &zero_near[{b.level, near, 0, 0}]})) return 0;
    const bool negative = in.bit(32768);
    int m = 1;
    for (; m <= 13; ++m) {
      Context& c = more.try_emplace({m, bucket, rest, 0}, first_guess(bucket, 160)).first->second;
      if (!mixed(more_mixer[{m, 0, 0, 0}], {&c, &more_near[{m, near, 0, 0}]})) break;
    }
    if (m == 14) m = large_magnitude();
    return negative ? -m : m;
  }

  void read_row(std::vector<Band>& bands, size_t which, int k, int z, int y) {
    Band& b = bands[which];
    int64_t sum = 0;
    for (int x = 0; x < b.size[0]; ++x) sum += expected_above(bands, which, k, z, y, x);
    if (!alone(row[{b.level, bucket_of(sum), 0, 0}])) return;
    for (int x = 0; x < b.size[0]; ++x) {
      const int bucket = bucket_of(expected(bands, which, k, z, y, x));
      b.steps[b.index(k, z, y, x)] = coefficient(b, k, bucket, near_of(b, k, z, y, x));
    }
  }

  void read_box(TileBox& box) {
    for (size_t which = 0; which < box.bands.size(); ++which) {
      const Band& b = box.bands[which];
      for (int k = 0; k < b.layers; ++k)
        for (int z = 0; z < b.size[2]; ++z)
          for (int y = 0; y < b.size[1]; ++y) read_row(box.bands, which, k, z, y);
    }
  }
};

// Values: a line of first the even, then the odd values becomes one in order.
void join_line(std::vector<float>& line) {
  const int n = static_cast<int>(line.size()), evens = (n + 1) / 2;
  const auto scale = static_cast<float>(1.149604398), inverse = static_cast<float>(1 / 1.149604398);
  std::vector<float> v(n);
  for (int i = 0; i < n; ++i) v[i] = i % 2 == 0 ? line[i / 2] * inverse : line[evens + i / 2] * scale;
  const float w[4] = {-0.4435068522f, -0.8829110762f, 0.05298011854f, 1.586134342f};
  for (int pass = 0; pass < 4; ++pass)
    for (int i = pass % 2; i < n; i += 2) {
      const float earlier = v[i > 0 ? i - 1 : 1], later = v[i < n - 1 ? i + 1 : n - 2];
      v[i] = v[i] + w[pass] * (earlier + later);
    }
  line = v;
}

// All lines along axis a of what level l puts together, in layer t.
void join_lines(TileBox& box, int t, int l, int a) {
  int size[3] = {};
  for (int i = 0; i < 3; ++i) size[i] = box.kept(i, l - 1);
  const int n = size[a];
  size[a] = 1;
  std::vector<float> line(n);
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x) {
        const auto value = [&](int i) -> float& {
          return box.at(t, a == 2 ? i : z, a == 1 ? i : y, a == 0 ? i : x);
        };
        for (int i = 0; i < n; ++i) line[i] = value(i);
        join_line(line);
        for (int i = 0; i < n; ++i) value(i) = line[i];
      }
}

struct TileHead {
  float step = 0;
  int centre[2] = {}, halvings[3] = {};
};

float value_of(const TileHead& head, int steps) {
  if (steps == 0) return 0;
  const auto magnitude = static_cast<float>(std::abs(steps));
  const float c = static_cast<float>(head.centre[std::abs(steps) == 1 ? 0 : 1] - 128) / 256;
  const float v = (magnitude + c) * head.step;
  return steps < 0 ? -v : v;
}

// Makes each layer the sum of all.
void change_basis(TileBox& box) {
  const std::vector<std::vector<float>> layers = box.samples;
  for (int t = 0; t < box.layers; ++t)
    for (size_t i = 0; i < layers[t].size(); ++i) {
      float sum = 0;
      for (int k = 0; k < box.layers; ++k)
        sum = sum + static_cast<float>(box.time[k][t]) / 16384 * layers[k][i];
      box.samples[t][i] = sum;
    }
}

void make_samples(TileBox& box, const TileHead& head, bool linear) {
  box.samples.assign(box.layers, std::vector<float>(box.n[0] * box.n[1] * box.n[2]));
  for (Band& b : box.bands)
    for (int k = 0; k < b.layers; ++k)
      for (int z = 0; z < b.size[2]; ++z)
        for (int y = 0; y < b.size[1]; ++y)
          for (int x = 0; x < b.size[0]; ++x)
            box.at(k, b.from[2] + z, b.from[1] + y, b.from[0] + x) =
                value_of(head, b.steps[b.index(k, z, y, x)]);
  if (linear) change_basis(box);
  for (int k = 0; k < box.layers; ++k)
    for (int l = box.levels; l >= 1; --l)
      for (int a = 2; a >= 0; --a)
        if (box.h[a] >= l && box.kept(a, l - 1) > 1) join_lines(box, k, l, a);
  if (!linear) change_basis(box);
}

// The values part: the boxes of the cosets that have sites in the tile, without their samples.
std::map<int, TileBox> read_boxes(Cursor& c, const Volume& v, const Chunk& e, const int at[3],
                                  TileHead& head) {
  head.step = c.f32();
  must(head.step > 0 && head.step <= 0x1p24F, "tile: step");
  for (int& centre : head.centre) centre = c.u8();
  for (int& h : head.halvings) {
    h = c.u8();
    must(h <= 5, "tile: halvings");
  }
  std::map<int, TileBox> boxes;
  for (int m = static_cast<int>(e.slab) * v.slab_layers, i = 0; i < v.slab_layers && m < v.layers(); ++i, ++m)
    ++boxes[v.coset(m)].layers;
  for (int coset = 0; coset < 2; ++coset) {
    if (boxes.count(coset) == 0) continue;
    TileBox& box = boxes[coset];
    bool empty = false;
    for (int a = 0; a < 3; ++a) {
      box.n[a] = std::min(v.sites(coset, a) - 16 * v.tile * at[a], 16 * v.tile);
      if (box.n[a] <= 0) empty = true;
      box.h[a] = std::min(head.halvings[a], std::max(0, bits_of(box.n[a]) - 2));
      box.levels = std::max(box.levels, box.h[a]);
    }
    if (empty) {
      boxes.erase(coset);
      continue;
    }
    const int basis = c.u8();
    must(basis <= 1, "tile: basis of time");
    box.time = cosines(box.layers);
    if (basis == 1)
      for (auto& row : box.time)
        for (int& b : row) b = static_cast<int16_t>(c.u16());
  }
  return boxes;
}

// The code of a kept site.
uint32_t code_of(float sample, const Channel& ch, const Chunk& e) {
  const float code = std::floor(sample + static_cast<float>(ch.air_code) + 0.5f);
  must(!std::isnan(code), "tile: a sample is not a number");
  const float low = ch.linear ? 0 : static_cast<float>(e.smallest), high = !ch.linear
                                                                               ? static_cast<float>(e.largest)
                                                                           : ch.type == 1 ? 255
                                                                                          : 65535;
  return static_cast<uint32_t>(std::clamp(code, low, high));
}

float relative(const Channel& ch, uint32_t code);

// Which tile a chunk is.
void find_tile(const Volume& v, const Chunk& e, int at[3]) {
  uint64_t slot = e.slot;
  for (int a = 0; a < 3; ++a) {
    const int tiles = (v.bricks(a) + v.tile - 1) / v.tile;
    at[a] = static_cast<int>(slot % tiles);
    slot /= tiles;
  }
  must(slot == 0, "page: slot");
}

std::vector<Brick> bricks_of_tile(const Volume& v, const Chunk& e, const int at[3]) {
  int from[3], to[3];
  for (int a = 0; a < 3; ++a) {
    from[a] = v.tile * at[a];
    to[a] = std::min(from[a] + v.tile, v.bricks(a));
  }
  std::vector<Brick> bricks;
  for (int z = from[2]; z < to[2]; ++z)
    for (int y = from[1]; y < to[1]; ++y)
      for (int x = from[0]; x < to[0]; ++x) bricks.emplace_back(v, e.slab, x, y, z);
  return bricks;
}

// The bricks of a tile, by slot.
std::map<uint32_t, Decoded> decode_tile(const File& f, const Volume& v, const Channel& ch, const Chunk& e) {
  const uint8_t* p = chunk_bytes(f, e);
  must((e.coding & 15) == 2 && e.predictor == 0, "tile: coding");
  int at[3];
  find_tile(v, e, at);
  const std::vector<Brick> bricks = bricks_of_tile(v, e, at);
  uint64_t sites = 0;
  for (const Brick& b : bricks) sites += b.sites;
  const auto [kept, hole] = read_kept(p, e, sites);

  Cursor values(p, e.values);
  TileHead head;
  std::map<int, TileBox> boxes = read_boxes(values, v, e, at, head);
  Coefficients coefficients(values);
  for (auto& [coset, box] : boxes) {
    make_bands(box);
    coefficients.read_box(box);
    make_samples(box, head, ch.linear);
  }

  std::map<uint32_t, Decoded> all;
  size_t site = 0, value = 0;
  uint32_t smallest = UINT32_MAX, largest = 0;
  for (const Brick& b : bricks) {
    Decoded& out = all[(b.at[2] * v.bricks(1) + b.at[1]) * v.bricks(0) + b.at[0]];
    int from[3], layers[2] = {}; // in the boxes; of each coset, so far
    for (int a = 0; a < 3; ++a) from[a] = 16 * (b.at[a] - v.tile * at[a]);
    for (size_t m = 0; m < b.layers.size(); ++m) {
      out.state.emplace_back(4096);
      out.code.emplace_back(4096);
      out.sample.emplace_back(4096);
      const int coset = v.coset(static_cast<int>(e.slab * v.slab_layers + m)), t = layers[coset]++;
      const auto [nx, ny, nz] = b.layers[m];
      for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
          for (int x = 0; x < nx; ++x) {
            if (!kept[site++]) continue;
            const float sample = boxes.at(coset).at(t, from[2] + z, from[1] + y, from[0] + x);
            const uint32_t code = code_of(sample, ch, e);
            const size_t index = (z * 16 + y) * 16 + x;
            out.state.back()[index] = hole[value++] ? 2 : 1;
            out.code.back()[index] = code;
            out.sample.back()[index] = static_cast<float>(ch.scale) * sample + relative(ch, ch.air_code);
            smallest = std::min(smallest, code), largest = std::max(largest, code);
          }
    }
  }
  must(smallest == e.smallest && largest == e.largest, "tile: smallest and largest sample");
  return all;
}

// ---- Section 6: codes to samples ----

double half(uint32_t bits) {
  const double sign = bits & 0x8000 ? -1 : 1;
  const int exponent = bits >> 10 & 31, mantissa = bits & 1023;
  must(exponent != 31, "a sample is not finite");
  return sign * (exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25));
}

float relative(const Channel& ch, uint32_t code) {
  const double bias = ch.offset - ch.air;
  if (ch.type <= 2) return static_cast<float>(code * ch.scale + bias);
  const uint32_t sign = ch.type == 3 ? 0x8000u : 0x80000000u, mask = ch.type == 3 ? 0xffffu : 0xffffffffu;
  const uint32_t pattern = code & sign ? code - sign : ~code & mask;
  if (ch.type == 3) return static_cast<float>(bias == 0 ? half(pattern) : half(pattern) + bias);
  float v;
  std::memcpy(&v, &pattern, 4);
  must(std::isfinite(v), "a sample is not finite");
  return v;
}

// ---- The whole file ----

// Section 2. The root, as a cursor behind its file size; sets file.size.
Cursor read_preamble(File& file) {
  const uint8_t magic[12] = {0x89, 'B', 'C', 'C', '4', 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0xff, 0xfe};
  must(file.bytes.size() >= 192 && std::memcmp(file.bytes.data(), magic, 12) == 0, "not a .bcc4 file");
  Cursor header(file.bytes.data() + 12, 52);
  header.u16();
  const uint16_t lowest = header.u16();
  header.zeros(44);
  must(header.u32() == crc(file.bytes.data(), 60), "header: checksum");
  must(lowest == 5, "needs a reader of another version");
  const auto valid = [&file](size_t at) {
    const uint8_t* p = file.bytes.data() + at;
    return std::memcmp(p, "BCC4ROOT", 8) == 0 && Cursor(p + 124, 4).u32() == crc(p, 124) &&
           Cursor(p + 8, 8).u64() >= 1;
  };
  size_t root = 64;
  if (!valid(root)) {
    root = file.bytes.size() - 128;
    must(root >= 192 && valid(root) && Cursor(file.bytes.data() + root + 16, 8).u64() == file.bytes.size(),
         "no valid root");
  }
  Cursor c(file.bytes.data() + root + 16, 112 - 4);
  file.size = c.u64();
  must(file.size <= file.bytes.size(), "the file is cut short");
  return c;
}

// ---- Section 10: corrections ----

struct Correction {
  uint64_t voxel;
  int64_t steps;
};

std::vector<Correction> read_list(Cursor& c, uint64_t n, uint64_t voxels) {
  must(n <= c.left() / 2, "corrections: count");
  std::vector<Correction> list;
  uint64_t next = 0;
  for (uint64_t i = 0; i < n; ++i) {
    const uint64_t skip = c.varint();
    must(next < voxels && skip < voxels - next, "corrections: voxel");
    list.push_back({next + skip, 0});
    next += skip + 1;
  }
  for (Correction& k : list) {
    const uint64_t v = c.varint();
    k.steps = v % 2 == 0 ? static_cast<int64_t>(v / 2) : -static_cast<int64_t>(v / 2) - 1;
  }
  return list;
}

void add_number(Bytes& to, uint64_t v) {
  for (int i = 0; i < 8; ++i) to.push_back(static_cast<uint8_t>(v >> (8 * i)));
}

void add_list(Bytes& to, const std::vector<Correction>& list) {
  for (const Correction& c : list) add_number(to, c.voxel), add_number(to, c.steps);
}

// The bricks of a frame; returns how many corrections they have.
uint64_t read_bricks(const File& file, const Volume& v, const Channel& ch, const BlockRef& table,
                     Bytes& all) {
  const Bytes bytes = table.read(file);
  Cursor t(bytes);
  uint64_t per[3], bricks = 1, sum = 0;
  for (int a = 0; a < 3; ++a) bricks *= per[a] = (uint64_t{v.dims[a]} + 63) / 64;
  int64_t last = -1;
  for (uint32_t n = t.u32(); n > 0; --n) {
    const uint32_t brick = t.u32();
    const float low = t.f32(), high = t.f32();
    const uint32_t count = t.u32();
    const BlockRef block(t);
    must(brick < bricks && int64_t{brick} > last, "corrections: bricks do not rise");
    last = brick;
    must(std::isfinite(low) && std::isfinite(high) && low <= high, "corrections: bounds");
    must(count >= 1 && count <= 64 * 64 * 64, "corrections: count of a brick");
    const Bytes decoded = block.read(file);
    Cursor c(decoded);
    must(c.u32() == count, "corrections: counts differ");
    const std::vector<Correction> list = read_list(c, count, 64 * 64 * 64);
    must(c.left() == 0, "corrections: bytes are left");
    const uint64_t from[3] = {brick % per[0] * 64, brick / per[0] % per[1] * 64,
                              brick / per[0] / per[1] * 64};
    for (const Correction& k : list) {
      const uint64_t at[3] = {k.voxel % 64, k.voxel / 64 % 64, k.voxel / 4096};
      for (int a = 0; a < 3; ++a) must(from[a] + at[a] < v.dims[a], "corrections: beyond the frame");
      const auto value = static_cast<float>(static_cast<double>(k.steps) * ch.step);
      must(value >= low && value <= high, "corrections: beyond the bounds");
    }
    add_number(all, brick);
    add_list(all, list);
    sum += count;
  }
  must(t.left() == 0, "corrections: table too long");
  return sum;
}

void dump_corrections(const File& file, const Volume& v, const Channel& ch) {
  if (ch.step == 0 && ch.bound == 0) return;
  uint64_t all_frames = 0;
  std::printf("corrections step %.17g bound %.17g shape %d", ch.step, ch.bound, ch.shape);
  if (ch.base) std::printf(" base %.17g", static_cast<double>(*ch.base));
  std::printf("\n");
  for (uint32_t f = 0; f < v.dims[3]; ++f) {
    Bytes all;
    uint64_t add = 0, set = 0;
    if (!ch.tables.empty() && ch.tables[f].stored > 0) add = read_bricks(file, v, ch, ch.tables[f], all);
    if (!ch.frames.empty() && ch.frames[f].stored > 0) {
      const Bytes decoded = ch.frames[f].read(file);
      Cursor c(decoded);
      const uint64_t a = c.u32(), b = c.u32(), voxels = uint64_t{v.dims[0]} * v.dims[1] * v.dims[2];
      must(ch.shape < 0 || a == 0, "corrections: to add, beside those in bricks");
      add_list(all, read_list(c, a, voxels)), add_list(all, read_list(c, b, voxels));
      must(c.left() == 0, "corrections: bytes are left");
      add += a, set += b;
    }
    std::printf("corrections frame %u add %llu set %llu crc %08x\n", f, static_cast<unsigned long long>(add),
                static_cast<unsigned long long>(set), crc(all.data(), all.size()));
    all_frames += add + set;
  }
  must(!ch.sums || ch.sums->corrected == all_frames, "sums: not those of the corrections");
}

// ---- Record 10: masks ----

// Returns a byte for each voxel of a frame that has the mask: whether it is missing.
Bytes read_mask(const File& file, const Volume& v, const BlockRef& block) {
  const uint64_t voxels = uint64_t{v.dims[0]} * v.dims[1] * v.dims[2];
  const Bytes decoded = block.read(file);
  Cursor c(decoded);
  uint64_t at = 0;
  Bytes missing;
  while (c.left() > 0) {
    const uint64_t skip = c.varint(), run = c.varint();
    must(run >= 1 && (skip >= 1 || at == 0), "mask: an empty pair");
    must(skip <= voxels - at && run <= voxels - at - skip, "mask: beyond the frame");
    missing.resize(at + skip), missing.resize(at + skip + run, 1);
    at += skip + run;
  }
  must(at > 0, "mask: empty");
  missing.resize(voxels);
  return missing;
}

void dump_masks(const File& file, const Volume& v, const Channel& ch) {
  uint64_t all_frames = 0;
  for (uint32_t f = 0; f < ch.masks.size(); ++f) {
    if (ch.masks[f].stored == 0) {
      std::printf("mask frame %u missing 0\n", f);
      continue;
    }
    const Bytes missing = read_mask(file, v, ch.masks[f]);
    const auto count = std::count(missing.begin(), missing.end(), 1);
    std::printf("mask frame %u missing %lld crc %08x\n", f, static_cast<long long>(count),
                crc(missing.data(), missing.size()));
    all_frames += static_cast<uint64_t>(count);
  }
  must(!ch.sums || ch.sums->missing == all_frames, "sums: not those of the masks");
}

using Slots = std::map<uint32_t, Decoded>;
using Chunks = std::map<std::tuple<uint32_t, uint32_t, uint32_t>, Slots>; // level, channel, slab

// Prints a channel of a level, layer by layer; each line begins with `name`.
void dump_layers(const Volume& v, uint32_t c, uint32_t level, const std::string& name, Chunks& chunks) {
  const Channel& ch = v.channels[c];
  for (int m = 0; m < v.layers(); ++m) {
    const int coset = v.coset(m), n[3] = {v.sites(coset, 0), v.sites(coset, 1), v.sites(coset, 2)};
    const Slots& slab = chunks[{level, c, static_cast<uint32_t>(m / v.slab_layers)}];
    Bytes all;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) {
          const uint32_t slot = (z / 16 * v.bricks(1) + y / 16) * v.bricks(0) + x / 16;
          const auto found = slab.find(slot);
          uint8_t state = 0;
          float sample = 0;
          if (found != slab.end()) {
            const size_t layer = m % v.slab_layers;
            const size_t index = (z % 16 * 16 + y % 16) * 16 + x % 16;
            state = found->second.state[layer][index];
            if (state)
              sample = ch.linear ? found->second.sample[layer][index]
                                 : relative(ch, found->second.code[layer][index]);
          }
          uint8_t bytes[4];
          std::memcpy(bytes, &sample, 4);
          all.push_back(state);
          all.insert(all.end(), bytes, bytes + 4);
        }
    std::printf("%slayer %d sites %d %d %d crc %08x\n", name.c_str(), m, n[0], n[1], n[2],
                crc(all.data(), all.size()));
  }
}

void dump(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  must(static_cast<bool>(in), "cannot open the file");
  File file;
  file.bytes.assign(std::istreambuf_iterator<char>(in), {});
  Cursor root = read_preamble(file);
  const BlockRef metadata(root), directory(root);
  const uint64_t chunk_count = root.u64();
  root.take(24); // bytes of runs, values and index
  const uint32_t state = root.u32(), frames = root.u32();
  must(state <= 1, "root: state");
  must((state == 1) == (frames > 0), "root: frames that can be looked at");
  root.zeros(12);
  const Volume v = read_metadata(metadata.read(file));
  if (state == 1) {
    must(frames <= v.dims[3], "root: more frames than the series has");
    std::printf("unfinished, %u frames can be looked at\n", frames);
  }
  std::printf("lattice kind %d dims %u %u %u %u planes %d %d %d layers %d\n", v.kind, v.dims[0], v.dims[1],
              v.dims[2], v.dims[3], v.last_plane[0], v.last_plane[1], v.last_plane[2], v.layers());
  for (int a = 0; a < 3; ++a)
    if (v.before[a] + v.behind[a] > 0)
      std::printf("%c planes outside %d %d\n", "xyz"[a], v.before[a], v.behind[a]);
  if (v.periodic) std::printf("periodic in time\n");
  for (int a = 0; a < 3; ++a)
    if (v.round[a]) std::printf("periodic along %c\n", "xyz"[a]);
  for (size_t l = 0; l < v.levels.size(); ++l)
    std::printf("lattice of level %zu planes %d %d %d layers %d\n", l + 1, v.levels[l].last_plane[0],
                v.levels[l].last_plane[1], v.levels[l].last_plane[2], v.levels[l].layers());
  for (size_t a = 0; a < v.axes.size(); ++a) {
    std::printf("axis %c unit '%s'%s coordinates %zu\n", "xyz"[a], v.axes[a].unit.c_str(),
                v.axes[a].down ? " down" : "", v.axes[a].coordinates.size());
    for (const double c : v.axes[a].coordinates) std::printf("coordinate %.17g\n", c);
  }
  if (v.times.empty()) std::printf("times %.17g step %.17g\n", v.first, v.step);
  for (const double t : v.times) std::printf("time %.17g\n", t);
  std::printf("recommended kernel %s\n", v.recommended.c_str());
  for (const auto& [key, value] : v.attributes)
    std::printf("attribute %s = %s\n", key.c_str(), value.c_str());

  // Decodes everything, then prints layer by layer.
  Chunks chunks;
  const Bytes records = directory.read(file);
  must(records.size() % 64 == 0, "directory: size");
  Cursor d(records);
  uint64_t count = 0;
  std::map<std::pair<uint32_t, uint32_t>, std::pair<uint64_t, uint64_t>>
      counts;                                               // channel, level: kept, holes
  std::tuple<uint32_t, uint32_t, int32_t, uint32_t> next{}; // channel, level, and chunk: those behind them
  while (d.left() > 0) {
    const uint32_t channel = d.u32();
    must(channel < v.channels.size(), "directory: channel");
    const int32_t first_slab = d.i32();
    const uint32_t first_slot = d.u32();
    const int32_t last_slab = d.i32();
    const uint32_t last_slot = d.u32();
    const uint32_t entries = d.u32();
    const BlockRef page(d);
    d.take(8); // smallest and largest sample
    const uint32_t level = d.u32();
    must(level <= v.levels.size(), "directory: level");
    d.zeros(4);
    must(std::tuple(channel, level, first_slab, first_slot) >= next, "directory: pages do not rise");
    next = {channel, level, last_slab, last_slot + 1};
    const Volume& lattice = level == 0 ? v : v.levels[level - 1];
    const std::vector<Chunk> list = read_page(page.read(file));
    must(list.size() == entries, "directory: entries");
    count += entries;
    for (const Chunk& e : list) {
      must(e.slab * static_cast<uint64_t>(lattice.slab_layers) < static_cast<uint64_t>(lattice.layers()),
           "page: slab");
      counts[{channel, level}].first += e.kept, counts[{channel, level}].second += e.holes;
      Slots& slots = chunks[{level, channel, e.slab}];
      if (v.tile == 0)
        slots[e.slot] = decode(file, lattice, lattice.channels[channel], e);
      else
        slots.merge(decode_tile(file, lattice, lattice.channels[channel], e));
    }
  }
  must(count == chunk_count, "root: chunks");
  for (uint32_t c = 0; c < v.channels.size(); ++c) {
    const Channel& ch = v.channels[c];
    const auto count_of = [&](uint32_t level) { return counts[{c, level}]; };
    must(count_of(0) == std::pair(ch.kept, ch.holes), "channel: counts");
    std::printf("channel %u %s type %d air %.9g kept %llu holes %llu\n", c, ch.name.c_str(), ch.type,
                static_cast<double>(ch.air), static_cast<unsigned long long>(ch.kept),
                static_cast<unsigned long long>(ch.holes));
    dump_layers(v, c, 0, "", chunks);
    for (uint32_t l = 1; l <= v.levels.size(); ++l) {
      const Volume& level = v.levels[l - 1];
      const auto [kept, holes] = std::pair(level.channels[c].kept, level.channels[c].holes);
      must(count_of(l) == std::pair(kept, holes), "level: counts");
      std::printf("level %u channel %u kept %llu holes %llu\n", l, c, static_cast<unsigned long long>(kept),
                  static_cast<unsigned long long>(holes));
      dump_layers(level, c, l, "level " + std::to_string(l) + " ", chunks);
    }
    dump_corrections(file, v, ch);
    dump_masks(file, v, ch);
    if (ch.sums)
      std::printf("sums corrected %llu missing %llu\n", static_cast<unsigned long long>(ch.sums->corrected),
                  static_cast<unsigned long long>(ch.sums->missing));
  }
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: bcc4_dump FILE\n", stderr);
    return 2;
  }
  try {
    dump(argv[1]);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", argv[1], e.what());
    return 1;
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
// Keeps the frames within reach of the next layer, makes each layer as soon as its frames are there, and
// hands finished slabs to the sink.
#include "fit/fit.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <deque>
#include <map>
#include <utility>

#include "base/sizes.h"
#include "fit/direct_layer.h"
#include "fit/end_layers.h"
#include "fit/holes.h"
#include "fit/layer.h"
#include "fit/lowpass.h"
#include "fit/resample.h"
#include "fit/scan.h"
#include "fit/site_axis.h"
#include "fit/site_block.h"

namespace bccsplat {
namespace {

constexpr uint64_t largest_layer = 16 << 20; // bricks: 4096^3 sites
// Largest departure from air: filters and prefilters multiply it by up to some hundred in 32-bit floats.
constexpr double largest_value = 1e36;

// One channel on its way through.
struct Channel {
  explicit Channel(const FitChannel& o)
      : options(o), maker(o.quantiser, o.threshold, o.ringing, o.unit, o.counted_step),
        lasting(maker.again()), uncounted(maker.again()) {}

  FitChannel options;
  // lasting: of the first layers; uncounted: of those beyond a part's own.
  LayerMaker maker, lasting, uncounted;
  FitChannelReport report;
  bool any_known = false; // a frame that is not missing altogether

  std::unique_ptr<Lowpass> lowpass; // null: none
  bool filtered = false;            // it has handed out all frames
  uint32_t given = 0;               // frames
  uint32_t frames = 0;              // those of them in the window or past it: a low-pass holds some back
  int32_t next_layer = 0;           // the first not made; of a periodic series counted on in the second turn
  std::deque<FrameSites> window;    // frames window_first ..
  uint32_t window_first = 0;
  std::vector<FrameSites>
      head; // of a periodic series: frames first_frame .. that are needed again at its end
  EndLevels end_levels;

  std::vector<SampleLayer> slab; // layers made and not handed out
  std::vector<Reservation> slab_memory;
  int32_t slab_index = 0;
};

// Returns how much the filter in time is stretched.
double time_widening(const Lattice4& lattice) {
  return lattice.is_static() ? 1 : std::max(1.0, lattice.time_step / lattice.layer_distance());
}

// Refuses what no reader would open either, before tables are made for it.
Lattice4 checked(const Lattice4& lattice) {
  uint64_t bricks = 1;
  for (const int32_t n : lattice.space.dims(0))
    bricks = checked_mul(bricks, static_cast<uint64_t>((n - 1) / brick_edge + 1));
  if (bricks > largest_layer)
    fail(Code::limit_exceeded, "a layer of ", bricks, " bricks of 16^3 sites is more than ", largest_layer,
         "; divide the volume or use a coarser lattice");
  return lattice;
}

// What a brick of a layer takes at most, codes that do not give back every value excepted (none do).
uint64_t most_bytes(ValueType type) {
  constexpr uint64_t beside_codes = 1400; // which sites are kept, where rows start
  return is_float(type) ? sizeof(Brick) : value_bytes(type) * brick_sites + beside_codes;
}

LayerCounts counts_of(const LayerMaker& maker, uint64_t sites_total) {
  SiteCounts counts = maker.counts();
  return {sites_total, counts.sites.kept, counts.sites.holes, counts.sites.clamped,
          std::move(counts.samples)};
}

} // namespace

Lattice4 lattice_of(const FitOptions& options, uint32_t frames) {
  return Lattice4::fit(options.lattice, {options.dims[0], options.dims[1], options.dims[2], frames},
                       options.scales, options.lead, options.margins, options.periodic, options.turning);
}

void LayerCounts::add(const LayerCounts& other) {
  sites_total += other.sites_total, sites_kept += other.sites_kept;
  holes += other.holes, clamped += other.clamped;
  samples.merge(other.samples);
}

struct Fit::State {
  State(const FitOptions& o, FitSink s, const Context& c, MaskSink m)
      : options(o), sink(std::move(s)), mask_sink(std::move(m)), context(c), pool(c.memory),
        lattice(checked(lattice_of(o, o.dims[3] > 0 ? o.dims[3] : 2))), ends(time_widening(lattice), o.lead) {
    if (options.channels.empty()) fail(Code::invalid_argument, "there is no channel");
    if (options.lead < 0 || options.lead % 2 != 0)
      fail(Code::invalid_argument, options.lead, " layers before the first frame; an even number is needed");
    if (options.slab_layers < 1) fail(Code::invalid_argument, "a slab has at least one layer");
    if (options.periodic && (options.dims[3] < 2 || options.lead > 0 || options.part))
      fail(Code::invalid_argument,
           "ends: a periodic series needs the number of its frames, at least 2, and has ",
           "neither layers beyond its ends nor parts");
    if (options.periodic) begin_turn();
    for (const FitChannel& channel : options.channels) {
      channels.push_back(std::make_unique<Channel>(channel));
      if (options.part) begin_part(*channels.back(), *options.part);
      if (options.lowpass) channels.back()->lowpass = std::make_unique<Lowpass>(lattice, channel.ringing);
      if (options.periodic) begin_turn(*channels.back());
    }
  }

  FitOptions options;
  FitSink sink;
  MaskSink mask_sink;
  Context context;
  SiteBlockPool pool;                                // outlives the channels
  Lattice4 lattice;                                  // of two frames as long as their number is not known
  std::map<FaceLevels, SpatialResampler> resamplers; // made when a frame needs them
  EndPredictions ends;
  std::vector<std::unique_ptr<Channel>> channels;
  bool layers_given = false; // instead of frames
  // Of a periodic series: the frame that the window begins with (a low-pass holds those before it back until
  // the end), the layer that can be made first, and the number of frames that are needed again at the end.
  uint32_t first_frame = 0;
  int32_t first_layer = 0;
  uint32_t head_frames = 0;
  bool finished = false;

  void begin_part(Channel& c, const FitPart& part) const {
    c.given = c.frames = c.window_first = part.first_given;
    c.next_layer = part.first_layer;
    c.slab_index = part.first_layer / options.slab_layers;
  }
  [[nodiscard]] bool counts_frame(uint32_t frame) const {
    return !options.part || (frame >= options.part->first_counted && frame < options.part->end_counted);
  }
  [[nodiscard]] bool counts_layer(int32_t layer) const {
    return !options.part || (layer >= options.part->first_own && layer < options.part->end_own);
  }
  // The first whole slab whose layers need no frame before the first one there is; all layers need the last
  // frames where there is none.
  void begin_turn() {
    if (options.lowpass) first_frame = static_cast<uint32_t>(lowpass_time_reach(lattice));
    const int reach = filter_reach(options.filter, time_widening(lattice));
    const double needed = first_frame + reach - 1.0;
    const auto layer = static_cast<int64_t>(std::ceil(needed / lattice.time_step));
    const int64_t slab = (layer + options.slab_layers - 1) / options.slab_layers * options.slab_layers;
    if (slab < lattice.layers()) first_layer = static_cast<int32_t>(slab);
    const double last = std::ceil(lattice.layer_frame(first_layer)) + reach + 1;
    const double frames = slab < lattice.layers() ? std::max(last - first_frame, 0.0) : options.dims[3];
    head_frames = static_cast<uint32_t>(std::min<double>(frames, options.dims[3]));
  }
  [[nodiscard]] int32_t end_layer() const {
    return options.part ? options.part->end_layer : first_layer + lattice.layers();
  }
  void begin_turn(Channel& c) const {
    c.frames = c.window_first = first_frame;
    c.next_layer = first_layer;
    c.slab_index = first_layer / options.slab_layers;
  }
  // A frame by its number in the series, or of a periodic one as counted from first_frame on.
  [[nodiscard]] const FrameSites& frame_at(const Channel& c, int64_t f) const {
    if (f < c.window_first) return c.head.at(static_cast<size_t>(f - first_frame));
    return c.window[static_cast<size_t>(f - c.window_first)];
  }

  [[nodiscard]] bool length_known() const { return options.dims[3] > 0 || finished; }

  [[nodiscard]] Channel& channel(int index) const {
    if (index < 0 || static_cast<size_t>(index) >= channels.size())
      fail(Code::invalid_argument, "there is no channel ", index);
    return *channels[static_cast<size_t>(index)];
  }

  // Refuses values so far from air that filters overflow.
  static void check_range(const Channel& c, double low, double high, bool finite, const std::string& what) {
    const auto air = static_cast<double>(c.options.quantiser.air);
    if (finite && (low - air < -largest_value || high - air > largest_value))
      fail(Code::limit_exceeded, what, ": its values reach from ", low, " to ", high, ", further than ",
           largest_value,
           " from air, where filters in 32-bit floats overflow; declare fill values missing, or scale the "
           "values");
  }
  static void note_range(Channel& c, double low, double high, bool finite) {
    if (!finite) return;
    FitChannelReport& r = c.report;
    r.source_range.low = r.any_finite ? std::min(r.source_range.low, low) : low;
    r.source_range.high = r.any_finite ? std::max(r.source_range.high, high) : high;
    r.any_finite = true;
  }

  // Returns what an infinity of a channel becomes, relative to air.
  std::array<float, 2> clamp_range(const Channel& c) const {
    const Range range = c.options.range.value_or(c.report.source_range);
    const auto relative = [&](double v) {
      return static_cast<float>(
          std::clamp(v - static_cast<double>(c.options.quantiser.air), -double{FLT_MAX}, double{FLT_MAX}));
    };
    if (!c.options.range && !c.report.any_finite) return {0, 0};
    return {relative(range.low), relative(range.high)};
  }

  [[nodiscard]] static std::string next_frame(const Channel& c) {
    return concat("channel '", c.options.name, "', frame ", c.given);
  }
  [[nodiscard]] Frame frame_of(const Channel& c, std::span<const FrameBox> boxes) const {
    return {boxes, source_dims(), c.options.quantiser.air, next_frame(c)};
  }

  // Whether a frame is not missing altogether: what is not finite may be clamped.
  [[nodiscard]] bool is_known(const FrameScan& scan) const {
    return scan.finite > 0 || (scan.nonfinite > 0 && options.nonfinite == NonFinite::clamp);
  }

  [[nodiscard]] FrameScan check_frame(int index, std::span<const FrameBox> boxes) const {
    const Channel& c = channel(index);
    if (c.given == INT32_MAX) fail(Code::limit_exceeded, "too many frames: at most 2147483647");
    const std::string what = next_frame(c);
    FrameScan scan = scan_frame(frame_of(c, boxes), c.options.threshold, context);
    if (scan.nonfinite > 0 && options.nonfinite == NonFinite::error)
      fail(Code::nonfinite_value, what, ": ", scan.nonfinite,
           " values are not finite, the first one at voxel (", scan.first_nonfinite[0], ", ",
           scan.first_nonfinite[1], ", ", scan.first_nonfinite[2], "); treat them as holes, or clamp them");
    if (!is_known(scan) && options.part && c.given > 0 && c.given == options.part->first_given)
      fail(Code::wrong_state, what, ": it is missing altogether; a part begins with a frame that is not");
    if (counts_frame(c.given)) check_range(c, scan.low, scan.high, scan.finite > 0, what);
    return scan;
  }

  PreparedFrame prepare_frame(int index, std::span<const FrameBox> boxes, const FrameScan& scan) {
    Channel& c = channel(index);
    PreparedFrame made{frame_of(c, boxes), scan, {}, usual_face_levels};
    if (counts_frame(c.given)) {
      note_range(c, scan.low, scan.high, scan.finite > 0);
      c.report.frames.push_back({scan.low, scan.high});
      c.report.source_samples += checked_product({options.dims[0], options.dims[1], options.dims[2]});
      c.report.cc_relevant += scan.relevant;
      c.report.nonfinite += scan.nonfinite;
    }
    if (scan.nonfinite > 0 && options.nonfinite == NonFinite::clamp) {
      const auto [low, high] = clamp_range(c);
      made.frame.clamp(low, high);
    }
    if (options.nonfinite == NonFinite::hole)
      made.holes = patch_holes(made.frame, scan, options.turning, context);
    if (options.masks && !made.holes.missing.empty())
      mask_sink(index, c.given, mask_runs(made.holes, made.frame.dims()));
    if (!c.lowpass) made.faces = faces_of(made.frame);
    return made;
  }
  [[nodiscard]] FaceLevels faces_of(const Frame& frame) const {
    return lattice.has_margins() ? choose_face_levels(frame, lattice) : usual_face_levels;
  }

  void add_frame(int index, const PreparedFrame& given, const FrameImage& image) {
    Channel& c = channel(index);
    ++c.given;
    if (c.lowpass) {
      const auto take = filtered(c, index);
      c.lowpass->add(is_known(given.scan) ? &given.frame : nullptr, given.holes.copy(context.memory), take,
                     context);
      if (c.given == options.dims[3]) finish_lowpass(c, index);
      return;
    }
    take_frame(c, index, image, is_known(given.scan), given.holes);
  }

  void finish_lowpass(Channel& c, int index) {
    if (c.lowpass && !std::exchange(c.filtered, true)) c.lowpass->finish(filtered(c, index), context);
  }

  // Takes a frame from the low-pass.
  Lowpass::Sink filtered(Channel& c, int index) {
    return [this, &c, index](const Frame& frame, const HoleMap& holes) {
      const FrameScan scan = scan_frame(frame, 0, context);
      take_frame(c, index, {frame, scan.cells, faces_of(frame)}, scan.finite > 0, holes);
    };
  }

  // known: not missing altogether.
  void take_frame(Channel& c, int index, const FrameImage& image, bool known, const HoleMap& holes) {
    // A frame that is missing altogether holds what the one before holds, the first ones what follows them.
    FrameSites sites;
    if (!known && !c.window.empty())
      sites.block = c.window.back().block;
    else
      sites = resampler_of(image).resample(image.frame, image.cells, c.options.unit, pool, context);
    if (known && !c.any_known) {
      for (FrameSites& earlier : c.head) earlier.block = sites.block;
      for (FrameSites& earlier : c.window) earlier.block = sites.block;
    }
    c.any_known = c.any_known || known;
    sites.holes = mark_sites(holes, lattice);
    sites.masked = options.masks;
    if (options.masks)
      sites.deep =
          mark_sites(deep_holes(holes, source_dims(), mask_reach(), options.turning, context), lattice);
    c.window.push_back(std::move(sites));
    ++c.frames;
    make_layers(c, index);
  }
  [[nodiscard]] std::array<int64_t, 3> source_dims() const {
    return {options.dims[0], options.dims[1], options.dims[2]};
  }

  const SpatialResampler& resampler_of(const FrameImage& image) {
    const auto found = resamplers.find(image.faces);
    if (found != resamplers.end()) return found->second;
    const Lattice4 seen = lattice_over(image.frame.dims());
    return resamplers.try_emplace(image.faces, seen, options.filter, image.faces).first->second;
  }
  // The lattice in samples of what the frames were halved to, whose first and last ones are those of the
  // source.
  [[nodiscard]] Lattice4 lattice_over(const std::array<int64_t, 3>& dims) const {
    Lattice4 seen = lattice;
    for (size_t a = 0; a < 3; ++a) {
      if (dims[a] == int64_t{lattice.dims[a]}) continue;
      const double was = lattice.domain_end(a);
      seen.dims[a] = static_cast<uint32_t>(dims[a]);
      seen.space_step[a] *= seen.domain_end(a) / was;
    }
    return seen;
  }

  // In source samples; that around a sample belongs to it for half a distance.
  [[nodiscard]] std::array<int64_t, 3> mask_reach() const {
    std::array<int64_t, 3> reach;
    for (size_t a = 0; a < 3; ++a)
      reach[a] = static_cast<int64_t>(std::ceil(options.mask_reach * lattice.space_step[a] + 0.5));
    return reach;
  }

  // Layers whose frames are all there. With one frame of an unknown number it is not yet known which lattice
  // it is.
  void make_layers(Channel& c, int index) {
    if (!length_known() && c.frames < 2) return;
    if (lattice.is_static()) {
      for (; c.frames > 0 && c.next_layer < lattice.layers(); ++c.next_layer) {
        const LayerTap tap{&c.window.front(), 1};
        emit(c, index, c.next_layer, {&tap, 1}, 0);
      }
      return;
    }
    const double widening = time_widening(lattice);
    const int64_t frames = finished         ? int64_t{c.frames}
                           : length_known() ? int64_t{options.dims[3]}
                                            : INT32_MAX;
    const bool complete = c.frames == frames + first_frame;
    if (options.periodic) return make_turning_layers(c, index, widening, complete);
    // Missing frames at the start wait for what they are to hold, as long as it can matter.
    if (!c.any_known && !complete &&
        c.frames <= 2 * filter_reach(options.filter, widening) + (options.lead > 0 ? ends.used() : 0))
      return;
    for (; !length_known() || c.next_layer < end_layer(); ++c.next_layer) {
      const double position = lattice.layer_frame(c.next_layer);
      const FilterTable table = layer_table(lattice, c.next_layer, length_known(), options.filter, widening);
      int64_t end = table.first[0] + table.taps;
      if (table.first[0] < 0) end = std::max(end, options.lead > 0 ? ends.used() : 0);
      if (!complete && end > c.frames) break;
      // Frames not yet known to end are not continued beyond their end; the first ones are in the same way
      // for any number.
      const int64_t n = complete ? frames : int64_t{c.frames};
      const int64_t nearest = nearest_sample(position, n);
      std::vector<LayerTap> taps;
      size_t nearest_tap = 0;
      for (const auto& [f, weight] : weighted_frames(c, table, n)) {
        if (f == nearest) nearest_tap = taps.size();
        taps.push_back({&c.window[static_cast<size_t>(f - c.window_first)], weight});
      }
      emit(c, index, c.next_layer, taps, nearest_tap);
    }
    forget_frames(c, widening);
  }

  // The same of a periodic series. Frames and layers are counted on beyond its end; the first layers are made
  // there.
  void make_turning_layers(Channel& c, int index, double widening, bool complete) {
    const int64_t there = int64_t{c.frames} - first_frame;
    if (!c.any_known && !complete && there <= 2 * filter_reach(options.filter, widening)) return;
    for (; c.next_layer < end_layer(); ++c.next_layer) {
      const double position = lattice.layer_frame(c.next_layer);
      const FilterTable table = filter_table(options.filter, widening, std::span(&position, 1));
      const int64_t begin = table.first[0], end = begin + table.taps;
      if (!complete && (begin < first_frame || end > c.frames)) break;
      std::vector<LayerTap> taps;
      std::map<int64_t, size_t> tap_of; // by frame: a short series turns several times within the filter
      for (int64_t f = begin; f < end; ++f) {
        const auto [at, is_new] = tap_of.try_emplace(counted_frame(f), taps.size());
        if (is_new) taps.push_back({&frame_at(c, at->first), 0});
        taps[at->second].weight += table.weight[static_cast<size_t>(f - begin)];
      }
      const int64_t nearest = counted_frame(lattice.nearest_frame(position));
      const auto found = tap_of.find(nearest);
      emit(c, index, lattice.mirror_layer(c.next_layer), taps, found == tap_of.end() ? 0 : found->second);
    }
    const auto needed = static_cast<int64_t>(std::floor(lattice.layer_frame(c.next_layer))) -
                        filter_reach(options.filter, widening);
    while (c.window.size() > 1 && c.window_first < needed) {
      if (c.window_first - first_frame < head_frames) c.head.push_back(std::move(c.window.front()));
      c.window.pop_front();
      ++c.window_first;
    }
  }
  // The number, from first_frame on, of a frame of any turn.
  [[nodiscard]] int64_t counted_frame(int64_t frame) const {
    return first_frame + lattice.turned_frame(frame - first_frame);
  }

  // Returns the taps of a layer; frames beyond the ends of a series of n are replaced by those that predict
  // them.
  std::vector<std::pair<int64_t, float>> weighted_frames(Channel& c, const FilterTable& table, int64_t n) {
    if (options.lead > 0) return ends.inside(table, n, [&](bool last) { return end_level(c, last, n); });
    std::vector<std::pair<int64_t, float>> list;
    for (int k = 0; k < table.taps; ++k)
      list.emplace_back(mirror_index(table.first[0] + k, n), table.weight[static_cast<size_t>(k)]);
    return list;
  }

  // How bold predictions at an end of a series of n frames are: settled by the frames they look at.
  uint8_t end_level(Channel& c, bool last, int64_t n) const {
    if (ends.levels() == 1) return 0;
    std::optional<uint8_t>& level = c.end_levels[last ? 1 : 0];
    if (level) return *level;
    std::vector<const FrameSites*> frames;
    for (int64_t k = 0; k < std::min(n, ends.used()); ++k)
      frames.push_back(&c.window[static_cast<size_t>((last ? n - 1 - k : k) - c.window_first)]);
    level = choose_end_level(frames, lattice.space, c.options.unit, time_widening(lattice));
    return *level;
  }

  // Frames that no further layer needs: neither directly nor to predict those beyond the last one.
  void forget_frames(Channel& c, double widening) {
    const int reach = filter_reach(options.filter, widening);
    const auto direct = static_cast<int64_t>(std::floor(lattice.layer_frame(c.next_layer))) - reach;
    const auto mirrored = int64_t{c.frames} - 2 - reach - static_cast<int64_t>(std::ceil(lattice.time_step));
    const int64_t predicted = int64_t{c.frames} - ends.used();
    while (!c.window.empty() && c.window_first < std::min(direct, options.lead > 0 ? predicted : mirrored)) {
      c.window.pop_front();
      ++c.window_first;
    }
  }

  void emit(Channel& c, int index, int32_t layer, std::span<const LayerTap> taps, size_t nearest) {
    const int coset = lattice.coset(layer);
    const bool beyond = layer < lattice.lead || (length_known() && layer > lattice.last_layer - lattice.lead);
    uint64_t bricks = 0;
    const BrickLayer shape(lattice.space, coset);
    for (size_t slot = 0; slot < shape.brick_slots(); ++slot)
      bricks += std::any_of(taps.begin(), taps.end(), [&](const LayerTap& tap) {
        return tap.frame->block[static_cast<size_t>(coset)][slot] != nullptr;
      });
    Reservation memory(context.memory, bricks * most_bytes(c.options.quantiser.type), "a slab of layers");
    const bool counted = counts_layer(layer), lasting = layer < options.lasting_layers;
    LayerMaker& maker = !counted ? c.uncounted : lasting ? c.lasting : c.maker;
    const uint64_t clamped_before = maker.clamped();
    c.slab.push_back(maker.make(lattice.space, coset, taps, nearest, beyond, context));
    memory = {};
    c.slab_memory.emplace_back(context.memory, c.slab.back().bytes(), "a slab of layers");
    if (counted) {
      (lasting ? c.report.lasting.sites_total : c.report.sites_total) +=
          static_cast<uint64_t>(lattice.space.sites(coset));
      const int32_t first = options.part ? options.part->first_own : 0;
      const auto slab = static_cast<size_t>((layer - first) / options.slab_layers);
      c.report.clamped_slabs.resize(std::max(c.report.clamped_slabs.size(), slab + 1));
      c.report.clamped_slabs[slab] += maker.clamped() - clamped_before;
    }
    const bool last = options.periodic && layer == lattice.last_layer;
    if (last || static_cast<int32_t>(c.slab.size()) == options.slab_layers) hand_out(c, index);
    if (last) c.slab_index = 0;
  }

  void hand_out(Channel& c, int index) {
    if (c.slab.empty()) return;
    sink(c.slab_index++, index, c.slab);
    c.slab.clear();
    c.slab_memory.clear();
  }

  // Layers are given from the first one on.
  void begin_layers() {
    layers_given = true;
    first_layer = 0;
    for (const auto& c : channels) c->next_layer = c->slab_index = 0;
  }

  [[nodiscard]] DirectLayerScan check_layer(int index, std::span<const float> samples) const {
    const Channel& c = channel(index);
    const int32_t layer = layers_given ? c.next_layer : 0;
    const int coset = lattice.coset(layer);
    if (samples.size() != static_cast<uint64_t>(lattice.space.sites(coset)))
      fail(Code::invalid_argument, "layer ", layer, " has ", lattice.space.sites(coset), " sites, not ",
           samples.size());
    const DirectLayerScan scan = scan_layer(samples, c.options.quantiser.air);
    const std::string what = concat("channel '", c.options.name, "', layer ", layer);
    if (scan.nonfinite > 0 && options.nonfinite == NonFinite::error) {
      const Int3 n = lattice.space.dims(coset);
      const auto nx = static_cast<size_t>(n[0]), ny = static_cast<size_t>(n[1]), first = scan.first_nonfinite;
      fail(Code::nonfinite_value, what, ": ", scan.nonfinite,
           " values are not finite, the first one at site (", first % nx, ", ", first / nx % ny, ", ",
           first / nx / ny, "); treat them as holes, or clamp them");
    }
    check_range(c, scan.low, scan.high, scan.finite > 0, what);
    return scan;
  }

  void add_layer(int index, std::span<const float> samples, const DirectLayerScan& scan) {
    Channel& c = channel(index);
    if (!layers_given) begin_layers();
    const int32_t layer = c.next_layer;
    const BrickLayer shape(lattice.space, lattice.coset(layer));
    const float air = c.options.quantiser.air;
    note_range(c, scan.low, scan.high, scan.finite > 0);
    c.report.source_samples += samples.size();
    c.report.nonfinite += scan.nonfinite;
    const FrameSites sites =
        layer_sites(shape, samples, air, options.nonfinite, clamp_range(c), pool, context);
    const LayerTap tap{&sites, 1};
    ++c.next_layer;
    emit(c, index, layer, {&tap, 1}, 0);
  }

  void shorten(uint32_t frames) {
    options.dims[3] = lattice.dims[3] = frames;
    if (layers_given)
      lattice.last_layer = channels.front()->next_layer - 1;
    else
      lattice = lattice_of(options, frames);
  }

  // The frames of the series as far as they were given.
  [[nodiscard]] uint32_t frames_given() const {
    return options.dims[3] > 0 ? options.dims[3] : channels.front()->given;
  }

  void check_end() const {
    for (const auto& c : channels) {
      if (layers_given) {
        if (c->next_layer != lattice.layers())
          fail(Code::wrong_state, "channel '", c->options.name, "' was given ", c->next_layer, " of its ",
               lattice.layers(), " layers");
        continue;
      }
      const uint32_t end = options.part ? options.part->end_given : frames_given();
      if (end == 0) fail(Code::wrong_state, "no frame was given");
      if (c->given != end)
        fail(Code::wrong_state, "channel '", c->options.name, "' was given ", c->given, " frames, not ", end);
    }
  }

  void end() {
    const uint32_t frames = frames_given();
    // A low-pass whose frames had no known end.
    if (!options.part && !layers_given)
      for (size_t i = 0; i < channels.size(); ++i) finish_lowpass(*channels[i], static_cast<int>(i));
    if (!layers_given) lattice = lattice_of(options, frames);
    finished = true;
  }

  void finish_channel(int index) {
    Channel& c = channel(index);
    // A part has made its layers by now, unless it ends with the series.
    const bool more = !options.part || options.part->end_given == lattice.dims[3];
    if (!layers_given && more) make_layers(c, index);
    if (c.next_layer != end_layer())
      fail(Code::internal, "layer ", c.next_layer, " of ", end_layer(), " could not be made");
    hand_out(c, index);
    c.window.clear();
  }

  [[nodiscard]] FitReport report() const {
    FitReport report{lattice, {}};
    for (const auto& channel : channels) {
      const Channel& c = *channel;
      FitChannelReport& r = report.channels.emplace_back(c.report);
      r.lasting = counts_of(c.lasting, c.report.lasting.sites_total);
      static_cast<LayerCounts&>(r) = counts_of(c.maker, c.report.sites_total);
      r.add(r.lasting);
      const CodingError &first = c.lasting.coding_error(), &coding = c.maker.coding_error();
      r.coding_max = std::max(first.largest, coding.largest);
      if (r.sites_total > 0)
        r.coding_rmse = std::sqrt((first.squares + coding.squares) / static_cast<double>(r.sites_total));
    }
    return report;
  }
};

Fit::Fit(const FitOptions& options, FitSink sink, const Context& context, MaskSink masks)
    : state_(std::make_unique<State>(options, std::move(sink), context, std::move(masks))) {}

Fit::~Fit() = default;

FrameScan Fit::check_frame(int channel, std::span<const FrameBox> boxes) const {
  return state_->check_frame(channel, boxes);
}

PreparedFrame Fit::prepare_frame(int channel, std::span<const FrameBox> boxes, const FrameScan& scan) {
  return state_->prepare_frame(channel, boxes, scan);
}

void Fit::add_frame(int channel, const PreparedFrame& frame, const FrameImage& image) {
  state_->add_frame(channel, frame, image);
}

DirectLayerScan Fit::check_layer(int channel, std::span<const float> samples) const {
  return state_->check_layer(channel, samples);
}

void Fit::add_layer(int channel, std::span<const float> samples, const DirectLayerScan& scan) {
  state_->add_layer(channel, samples, scan);
}

bool Fit::has_begun() const {
  return std::any_of(state_->channels.begin(), state_->channels.end(),
                     [](const auto& c) { return c->next_layer > 0; });
}

void Fit::shorten(uint32_t frames) { state_->shorten(frames); }

void Fit::check_end() const { state_->check_end(); }

void Fit::end() { state_->end(); }

void Fit::finish_channel(int channel) { state_->finish_channel(channel); }

FitReport Fit::report() const { return state_->report(); }

FitReport Fit::finish() {
  check_end();
  end();
  for (size_t c = 0; c < state_->channels.size(); ++c) finish_channel(static_cast<int>(c));
  return report();
}

const Lattice4& Fit::lattice() const { return state_->lattice; }

} // namespace bccsplat

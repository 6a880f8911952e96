// SPDX-License-Identifier: Apache-2.0
// mpirun -n N mpi_insitu OUT.bcc4 [NX,NY,NZ,FRAMES] [--resume]: a simulation on many ranks writes one file
// while it runs. Each rank owns a box of the domain, steps it with its neighbours' outermost cells, and hands
// each frame of its box, with a halo that the other ranks send, to a writer of its own: a block of space. At
// the end rank 0 joins the blocks, without coding anything again; the file is that of one rank, byte for
// byte.
//
// The simulation is the reaction of Gray and Scott: a substance v feeds on u, spreads and divides. A rank
// that fails says why, and nothing is joined; blocks that are finished stay, and with --resume a second run
// of as many ranks goes on where each one ended.
#include <bccsplat.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <mpi.h>
#include <sys/resource.h>

namespace {

using namespace bccsplat::client;
using Size = std::array<int64_t, 3>;

constexpr int steps_of_frame = 40;
constexpr float most_v = 0.6F; // v stays below

// Samples begin .. end - 1 along x, y and z.
struct Box {
  Size begin{}, end{};
  [[nodiscard]] int64_t length(size_t a) const { return std::max<int64_t>(0, end[a] - begin[a]); }
  [[nodiscard]] size_t samples() const { return static_cast<size_t>(length(0) * length(1) * length(2)); }
  [[nodiscard]] size_t at(int64_t x, int64_t y, int64_t z) const {
    return static_cast<size_t>(((z - begin[2]) * length(1) + y - begin[1]) * length(0) + x - begin[0]);
  }
  [[nodiscard]] Box cut(const Box& other) const {
    Box both;
    for (size_t a = 0; a < 3; ++a) {
      both.begin[a] = std::max(begin[a], other.begin[a]);
      both.end[a] = std::min(end[a], other.end[a]);
    }
    return both;
  }
  // Returns the box with one cell around it, as far as the domain goes.
  [[nodiscard]] Box grown(const Size& n) const {
    Box box;
    for (size_t a = 0; a < 3; ++a)
      box.begin[a] = std::max<int64_t>(0, begin[a] - 1), box.end[a] = std::min(n[a], end[a] + 1);
    return box;
  }
};

// Values of a box, x fastest.
struct Values {
  Box box;
  std::vector<float> value;
  explicit Values(const Box& b) : box(b), value(b.samples()) {}
  [[nodiscard]] float& operator()(int64_t x, int64_t y, int64_t z) { return value[box.at(x, y, z)]; }
  [[nodiscard]] float operator()(int64_t x, int64_t y, int64_t z) const { return value[box.at(x, y, z)]; }
};

template<class Body> void for_rows(const Box& box, const Body& body) {
  for (int64_t z = box.begin[2]; z < box.end[2]; ++z)
    for (int64_t y = box.begin[1]; y < box.end[1]; ++y) body(y, z);
}

std::vector<float> packed(const Values& from, const Box& box) {
  std::vector<float> out;
  for_rows(box, [&](int64_t y, int64_t z) {
    const auto row = from.value.begin() + static_cast<int64_t>(from.box.at(box.begin[0], y, z));
    out.insert(out.end(), row, row + box.length(0));
  });
  return out;
}

void unpack(const std::vector<float>& from, const Box& box, Values& to) {
  const float* next = from.data();
  for_rows(box, [&](int64_t y, int64_t z) {
    std::copy_n(next, box.length(0), &to(box.begin[0], y, z));
    next += box.length(0);
  });
}

// All ranks, each with a box of the domain.
struct Ranks {
  int rank = 0, count = 1;
  Size n{};
  std::vector<Box> own;
  uint64_t bytes_sent = 0;

  explicit Ranks(const Size& domain) : n(domain) {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &count);
    std::array<int, 3> grid{};
    MPI_Dims_create(count, 3, grid.data());
    for (int r = 0; r < count; ++r) { // the most pieces along z: rows stay long
      const Size place{r % grid[2], r / grid[2] % grid[1], r / (grid[2] * grid[1])};
      const Size pieces{grid[2], grid[1], grid[0]};
      Box& box = own.emplace_back();
      for (size_t a = 0; a < 3; ++a)
        box.begin[a] = n[a] * place[a] / pieces[a], box.end[a] = n[a] * (place[a] + 1) / pieces[a];
    }
  }
  [[nodiscard]] const Box& mine() const { return own[static_cast<size_t>(rank)]; }

  // Fills what others own of the box that this rank wants. wanted: of all ranks; from: has what this one
  // owns.
  void exchange(const std::vector<Box>& wanted, const Values& from, Values& to) {
    std::vector<MPI_Request> requests;
    std::vector<std::vector<float>> sent(own.size()), received(own.size());
    for (int r = 0; r < count; ++r) {
      const auto other = static_cast<size_t>(r);
      if (r == rank) continue;
      received[other].resize(own[other].cut(wanted[static_cast<size_t>(rank)]).samples());
      if (!received[other].empty())
        MPI_Irecv(received[other].data(), static_cast<int>(received[other].size()), MPI_FLOAT, r, 0,
                  MPI_COMM_WORLD, &requests.emplace_back());
    }
    for (int r = 0; r < count; ++r) {
      const auto other = static_cast<size_t>(r);
      const Box both = mine().cut(wanted[other]);
      if (r == rank || both.samples() == 0) continue;
      sent[other] = packed(from, both);
      bytes_sent += sent[other].size() * sizeof(float);
      MPI_Isend(sent[other].data(), static_cast<int>(sent[other].size()), MPI_FLOAT, r, 0, MPI_COMM_WORLD,
                &requests.emplace_back());
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    for (size_t r = 0; r < own.size(); ++r)
      if (!received[r].empty()) unpack(received[r], own[r].cut(wanted[static_cast<size_t>(rank)]), to);
  }
};

class GrayScott {
 public:
  explicit GrayScott(Ranks& ranks)
      : ranks_(ranks), u_(ranks.mine().grown(ranks.n)), v_(u_.box), next_u_(u_.box), next_v_(u_.box) {
    for (const Box& box : ranks.own) wanted_.push_back(box.grown(ranks.n));
    std::fill(u_.value.begin(), u_.value.end(), 1.0F);
    for (int i = 0; i < 9; ++i) { // drops of v
      Box drop;
      for (size_t a = 0; a < 3; ++a) {
        const int64_t middle = ranks.n[a] * (1 + (i * static_cast<int>(2 * a + 3)) % 7) / 8;
        drop.begin[a] = middle - 3, drop.end[a] = middle + 3;
      }
      const Box here = drop.cut(u_.box);
      for_rows(here.samples() > 0 ? here : Box{}, [&](int64_t y, int64_t z) {
        for (int64_t x = here.begin[0]; x < here.end[0]; ++x) u_(x, y, z) = 0.5F, v_(x, y, z) = 0.25F;
      });
    }
  }
  [[nodiscard]] const Values& v() const { return v_; }

  void step() {
    ranks_.exchange(wanted_, u_, u_), ranks_.exchange(wanted_, v_, v_);
    const Box& own = ranks_.mine();
    for_rows(own, [&](int64_t y, int64_t z) {
      for (int64_t x = own.begin[0]; x < own.end[0]; ++x) {
        constexpr float spread_u = 0.14F, spread_v = 0.06F, feed = 0.035F, kill = 0.06F;
        const float u = u_(x, y, z), v = v_(x, y, z), eaten = u * v * v;
        next_u_(x, y, z) = u + spread_u * bend(u_, x, y, z) - eaten + feed * (1 - u);
        next_v_(x, y, z) = v + spread_v * bend(v_, x, y, z) + eaten - (feed + kill) * v;
      }
    });
    std::swap(u_, next_u_), std::swap(v_, next_v_);
  }

 private:
  // The sum of differences from the six neighbours; nothing flows through the faces of the domain.
  [[nodiscard]] float bend(const Values& f, int64_t x, int64_t y, int64_t z) const {
    const auto clamped = [&](int64_t i, size_t a) { return std::clamp<int64_t>(i, 0, ranks_.n[a] - 1); };
    const float sum = f(clamped(x - 1, 0), y, z) + f(clamped(x + 1, 0), y, z) + f(x, clamped(y - 1, 1), z) +
                      f(x, clamped(y + 1, 1), z) + f(x, y, clamped(z - 1, 2)) + f(x, y, clamped(z + 1, 2));
    return sum - 6 * f(x, y, z);
  }

  Ranks& ranks_;
  std::vector<Box> wanted_;
  Values u_, v_, next_u_, next_v_;
};

// The writer of a rank's block; of one rank alone that of the file.
class Block {
 public:
  Block(Ranks& ranks, const std::string& path, uint32_t frames, bool resume)
      : ranks_(ranks), device_(make_device()), box_(ranks.mine()) {
    for (uint32_t t = 0; t < frames; ++t) times_.push_back(t);
    auto channel = sized<bccsplat_channel_options>();
    channel.name = "v", channel.source_type = BCCSPLAT_TYPE_F32, channel.value_type = BCCSPLAT_TYPE_U16;
    channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE, channel.range[1] = most_v;
    auto part = sized<bccsplat_series_part>();
    part.end = frames, part.times = times_.data();
    auto options = sized<bccsplat_writer_options>();
    for (size_t a = 0; a < 3; ++a) {
      options.dims[a] = static_cast<uint32_t>(ranks.n[a]);
      part.box_begin[a] = static_cast<uint64_t>(box_.begin[a]);
      part.box_end[a] = static_cast<uint64_t>(box_.end[a]);
    }
    options.dims[3] = frames;
    options.channels = &channel, options.channel_count = 1;
    options.fixed_predictions = 1; // a rank sees no more of a frame than its block
    if (ranks.count > 1) options.part = &part;
    options.partial = resume ? BCCSPLAT_PARTIAL_RESUME : BCCSPLAT_PARTIAL_KEEP;
    options.overwrite = 1;
    // A block that is finished is not written again, but other ranks may need its samples.
    std::error_code ignored;
    if (!resume || !std::filesystem::exists(path, ignored))
      writer_ = make(bccsplat_writer_create, device_.get(), path.c_str(), &options);
    if (writer_) {
      std::array<uint64_t, 3> begin{}, end{};
      check(bccsplat_writer_get_part_box(writer_.get(), begin.data(), end.data()));
      for (size_t a = 0; a < 3; ++a)
        box_.begin[a] = static_cast<int64_t>(begin[a]), box_.end[a] = static_cast<int64_t>(end[a]);
    }
    wanted_.resize(ranks.own.size());
    static_assert(sizeof(Box) == 6 * sizeof(int64_t));
  }
  // All ranks tell each other what they need; after all writers were made.
  void tell_boxes() { MPI_Allgather(&box_, 6, MPI_INT64_T, wanted_.data(), 6, MPI_INT64_T, MPI_COMM_WORLD); }
  void add_frame(const Values& own, uint32_t frame) {
    Values values(box_);
    const Box both = ranks_.mine().cut(box_);
    unpack(packed(own, both), both, values);
    ranks_.exchange(wanted_, own, values);
    if (!writer_) return;
    auto box = sized<bccsplat_box>();
    box.type = BCCSPLAT_TYPE_F32, box.data = values.value.data();
    for (size_t a = 0; a < 3; ++a) box.begin[a] = box_.begin[a], box.dims[a] = box_.length(a);
    check(bccsplat_writer_add_frame(writer_.get(), 0, times_[frame], &box, 1));
  }
  void finish() const {
    if (writer_) check(bccsplat_writer_finish(writer_.get(), nullptr));
  }
  [[nodiscard]] const Device& device() const { return device_; }

 private:
  static Device make_device() {
    auto options = sized<bccsplat_device_options>();
    options.thread_count = 1; // the other cores have ranks of their own
    return make(bccsplat_device_create, &options);
  }

  Ranks& ranks_;
  Device device_;
  Box box_;
  std::vector<double> times_;
  Writer writer_;
  std::vector<Box> wanted_;
};

// Returns whether all ranks are well; one that is not says why.
bool all_well(const Ranks& ranks, const std::string& failure) {
  if (!failure.empty()) std::fprintf(stderr, "mpi_insitu: rank %d: %s\n", ranks.rank, failure.c_str());
  int failed = failure.empty() ? 0 : 1, any = 0;
  MPI_Allreduce(&failed, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return any == 0;
}

// Takes a step of this rank; returns whether all ranks could.
template<class Step> bool together(const Ranks& ranks, const Step& step) {
  std::string failure;
  try {
    step();
  } catch (const std::exception& e) {
    failure = e.what();
  }
  return all_well(ranks, failure);
}

std::string block_name(const std::string& path, int rank) {
  return path + ".block" + std::to_string(rank) + ".bcc4";
}

void join(const Ranks& ranks, const Device& device, const std::string& path) {
  std::vector<std::string> names;
  std::vector<const char*> paths;
  for (int r = 0; r < ranks.count; ++r) names.push_back(block_name(path, r));
  for (const std::string& name : names) paths.push_back(name.c_str());
  auto options = sized<bccsplat_join_options>();
  options.overwrite = 1;
  check(bccsplat_join_parts(device.get(), paths.size(), paths.data(), path.c_str(), &options, nullptr));
  for (const std::string& name : names) std::filesystem::remove(name);
}

// Prints what each rank has used.
void report(const Ranks& ranks) {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  const std::array<double, 3> mine{seconds(used.ru_utime) + seconds(used.ru_stime),
                                   static_cast<double>(used.ru_maxrss) / 1024,
                                   static_cast<double>(ranks.bytes_sent) / (1 << 20)};
  std::vector<double> all(3 * ranks.own.size());
  MPI_Gather(mine.data(), 3, MPI_DOUBLE, all.data(), 3, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  if (ranks.rank != 0) return;
  std::printf("rank  CPU s  MiB held  MiB sent\n");
  for (size_t r = 0; r < ranks.own.size(); ++r)
    std::printf("%4zu %6.2f %9.1f %9.1f\n", r, all[3 * r], all[3 * r + 1], all[3 * r + 2]);
}

int run(const std::string& path, const Size& n, uint32_t frames, bool resume) {
  Ranks ranks(n);
  const std::string name = ranks.count == 1 ? path : block_name(path, ranks.rank);
  std::unique_ptr<Block> block;
  if (!together(ranks, [&] { block = std::make_unique<Block>(ranks, name, frames, resume); })) return 1;
  block->tell_boxes();
  GrayScott simulation(ranks);
  for (uint32_t t = 0; t < frames; ++t) {
    for (int s = 0; s < steps_of_frame && t > 0; ++s) simulation.step();
    if (!together(ranks, [&] { block->add_frame(simulation.v(), t); })) return 1;
  }
  if (!together(ranks, [&] { block->finish(); })) return 1;
  if (!together(ranks, [&] {
        if (ranks.count > 1 && ranks.rank == 0) join(ranks, block->device(), path);
      }))
    return 1;
  report(ranks);
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  const bool resume = argc > 2 && std::strcmp(argv[argc - 1], "--resume") == 0;
  long long x = 64, y = 64, z = 64;
  unsigned frames = 24;
  const bool sized = argc > 2 && std::strcmp(argv[2], "--resume") != 0;
  const bool known =
      argc > 1 && (!sized || std::sscanf(argv[2], "%lld,%lld,%lld,%u", &x, &y, &z, &frames) == 4);
  int status = 2;
  if (known && std::min({x, y, z}) >= 16 && frames > 0)
    status = run(argv[1], {x, y, z}, frames, resume);
  else
    std::fprintf(stderr, "usage: mpirun -n N mpi_insitu OUT.bcc4 [NX,NY,NZ,FRAMES] [--resume]\n");
  MPI_Finalize();
  return status;
}

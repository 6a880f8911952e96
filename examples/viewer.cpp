// SPDX-License-Identifier: Apache-2.0
// viewer FILE.bcc4 [--iso V[:OPACITY[:#RRGGBB]],...] [--gpu auto|on|off] [SCREENSHOT.bmp]: looks around in a
// series. It shows coarse pictures while something moves and, a little at a time, a fine one at rest; the
// window stays responsive, for pictures are made and cancelled in a thread of their own. With a screenshot
// the window is saved there when it closes, and the counts of pictures are printed.
#include "viewer/draw.h"
#include "viewer/panel.h"
#include "viewer/recorder.h"

#include <SDL.h>
#include <imgui.h>
#include <imgui_impl_sdl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>

namespace {

using namespace viewer;

struct DestroyWindow {
  void operator()(SDL_Window* w) const { SDL_DestroyWindow(w); }
  void operator()(SDL_Renderer* r) const { SDL_DestroyRenderer(r); }
  void operator()(SDL_Texture* t) const { SDL_DestroyTexture(t); }
  void operator()(SDL_Surface* s) const { SDL_FreeSurface(s); }
};
template<class T> using Sdl = std::unique_ptr<T, DestroyWindow>;

template<class T> T* needed(T* made) {
  if (!made) throw std::runtime_error(SDL_GetError());
  return made;
}

void save_window(SDL_Renderer* renderer, const char* path) {
  int width = 0, height = 0;
  SDL_GetRendererOutputSize(renderer, &width, &height);
  const Sdl<SDL_Surface> surface(
      needed(SDL_CreateRGBSurfaceWithFormat(0, width, height, 32, SDL_PIXELFORMAT_ARGB8888)));
  if (SDL_RenderReadPixels(renderer, nullptr, SDL_PIXELFORMAT_ARGB8888, surface->pixels, surface->pitch) !=
          0 ||
      SDL_SaveBMP(surface.get(), path) != 0)
    throw std::runtime_error(SDL_GetError());
}

// Turns the view with the mouse outside the panel. Angles follow from where the drag began, however seldom
// events are looked at.
class Orbit {
 public:
  void apply(Wish& wish) {
    const ImGuiIO& io = ImGui::GetIO();
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left))
      dragging_ = !io.WantCaptureMouse, start_ = {wish.rotate_x, wish.rotate_y};
    if (dragging_ && ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
      const ImVec2 moved = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0);
      wish.rotate_x = std::clamp(start_[0] + 0.4 * moved.y, -90.0, 90.0);
      wish.rotate_y = start_[1] + 0.4 * moved.x;
    }
    if (io.MouseWheel != 0 && !io.WantCaptureMouse)
      wish.zoom = std::clamp(wish.zoom * std::pow(1.15, static_cast<double>(io.MouseWheel)), 0.2, 20.0);
  }

 private:
  bool dragging_ = false;
  std::array<double, 2> start_{};
};

// Moves on in time, by the clock: where pictures take longer than a frame lasts some frames are not seen.
class Player {
 public:
  Play play;
  [[nodiscard]] int rounds() const { return rounds_; } // ends of the series met

  // A moment is left when its picture has come.
  void apply(Wish& wish, const Picture* shown, double last_frame) {
    const auto now = std::chrono::steady_clock::now();
    if (!play.on || last_frame == 0) {
      wish.playing = false;
      before_ = now;
      return;
    }
    if (wish.playing && !(shown && shown->wish.frame == wish.frame)) return;
    const double seconds = std::chrono::duration<double>(now - before_).count();
    before_ = now;
    wish.playing = true;
    wish.step = play.speed * seconds;
    wish.frame += wish.step;
    if (wish.frame <= last_frame) return;
    ++rounds_;
    play.on = play.loop;
    wish.frame = play.loop ? std::fmod(wish.frame, last_frame) : last_frame;
  }

 private:
  std::chrono::steady_clock::time_point before_;
  int rounds_ = 0;
};

struct Arguments {
  const char* path = nullptr;
  const char* screenshot = nullptr;
  std::vector<Surface> surfaces; // of --iso
  bccsplat_backend backend = BCCSPLAT_BACKEND_AUTO;
};

constexpr const char* help =
    "usage: viewer FILE.bcc4 [--iso V[:OPACITY[:#RRGGBB]],...] [--gpu auto|on|off] [SCREENSHOT.bmp]\n"
    "  --iso   begins with isosurfaces of these values; without it there is one, of the value that the "
    "file's\n"
    "          histogram says, and i shows it\n"
    "  --gpu   what draws: a graphics card where there is one, an OpenGL of any kind, or the CPU\n"
    "keys: space plays, r records, i switches between isosurfaces and opacities, up and down move the\n"
    "isosurfaces by a hundredth of the range, x, y and z cut open along an axis, [ and ] move the cuts,\n"
    "q quits; drag to orbit, wheel to zoom\n";

// Throws what is expected.
bccsplat_backend parse_backend(std::string_view word) {
  if (word == "auto") return BCCSPLAT_BACKEND_AUTO;
  if (word == "on") return BCCSPLAT_BACKEND_GPU;
  if (word == "off") return BCCSPLAT_BACKEND_CPU;
  throw std::runtime_error("--gpu: auto, on or off is expected");
}

// None when they make no sense.
std::optional<Arguments> read_arguments(int argc, char** argv) {
  Arguments a;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--iso" && i + 1 < argc)
      a.surfaces = parse_surfaces(argv[++i]);
    else if (word == "--gpu" && i + 1 < argc)
      a.backend = parse_backend(argv[++i]);
    else if (word.starts_with("--"))
      return std::nullopt;
    else if (!a.path)
      a.path = argv[i];
    else if (!a.screenshot)
      a.screenshot = argv[i];
    else
      return std::nullopt;
  }
  return a.path ? std::optional(a) : std::nullopt;
}

// By a twentieth of the box.
void move_cuts(Wish& wish, int steps) {
  for (size_t a = 0; a < wish.open.size(); ++a)
    if (wish.open[a]) wish.open_to[a] = std::clamp(wish.open_to[a] + 0.05 * steps, 0.0, 1.0);
}

// Keys that change what is shown.
void apply_key(SDL_Keycode key, Wish& wish, Play& play, const Facts& facts) {
  if (key == SDLK_SPACE) play.on = !play.on;
  if (key == SDLK_r) play.record = !play.record;
  if (key == SDLK_i) wish.iso = !wish.iso;
  constexpr std::array<SDL_Keycode, 3> axes{SDLK_x, SDLK_y, SDLK_z};
  for (size_t a = 0; a < axes.size(); ++a)
    if (key == axes[a]) wish.open[a] = !wish.open[a];
  if (key == SDLK_LEFTBRACKET) move_cuts(wish, -1);
  if (key == SDLK_RIGHTBRACKET) move_cuts(wish, 1);
  if (wish.iso && key == SDLK_UP) move_surfaces(wish.surfaces, facts.range, 1);
  if (wish.iso && key == SDLK_DOWN) move_surfaces(wish.surfaces, facts.range, -1);
}

int run(const Arguments& arguments) {
  const char* const screenshot = arguments.screenshot;
  bccsplat_device* d = nullptr;
  auto options = sized<bccsplat_device_options>();
  options.backend = arguments.backend;
  check(bccsplat_device_create(&options, &d));
  const Handle<bccsplat_device> device(d);
  bccsplat_volume* v = nullptr;
  check(bccsplat_volume_open_file(d, arguments.path, nullptr, &v));
  const Handle<bccsplat_volume> volume(v);
  const Facts facts = read_facts(v);

  const Sdl<SDL_Window> window(needed(SDL_CreateWindow(
      "bccsplat viewer", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, 1000, 680, SDL_WINDOW_RESIZABLE)));
  const Sdl<SDL_Renderer> renderer(needed(SDL_CreateRenderer(window.get(), -1, 0)));
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui_ImplSDL2_InitForSDLRenderer(window.get());
  upload_fonts(renderer.get());

  Wish wish;
  wish.frame = facts.last_frame / 2;
  wish.opacity = facts.opacity;
  wish.iso = !arguments.surfaces.empty();
  wish.surfaces = wish.iso ? arguments.surfaces : std::vector{Surface{.value = facts.iso_value}};
  Worker worker(d, v, facts.range);
  std::unique_ptr<Picture> shown;
  Sdl<SDL_Texture> texture;
  Orbit orbit;
  Player player;
  Recorder recorder;
  for (bool open = true; open;) {
    // At rest there is nothing to do but to wait for the mouse or a picture.
    SDL_Event event;
    for (bool any = SDL_WaitEventTimeout(&event, 15); any; any = SDL_PollEvent(&event)) {
      ImGui_ImplSDL2_ProcessEvent(&event);
      const bool q = event.type == SDL_KEYDOWN && event.key.keysym.sym == SDLK_q;
      if (event.type == SDL_QUIT || q) open = false;
      if (event.type == SDL_KEYDOWN) apply_key(event.key.keysym.sym, wish, player.play, facts);
    }
    bool fresh = false;
    if (auto newer = worker.take()) {
      shown = std::move(newer);
      fresh = true;
      if (shown->error.empty()) {
        texture.reset(needed(SDL_CreateTexture(renderer.get(), SDL_PIXELFORMAT_ABGR8888,
                                               SDL_TEXTUREACCESS_STATIC, shown->width, shown->height)));
        SDL_UpdateTexture(texture.get(), nullptr, shown->pixels.data(), shown->width * 4);
      }
      if (shown->fine && shown->wish == wish) SDL_SetWindowTitle(window.get(), "bccsplat viewer (at rest)");
    }
    ImGui_ImplSDL2_NewFrame();
    ImGui::NewFrame();
    recorder.apply(player.play.record, shown.get(), fresh);
    panel(wish, player.play, facts, shown.get(), worker.counts(), recorder.told());
    orbit.apply(wish);
    player.apply(wish, shown.get(), facts.last_frame);
    int width = 0, height = 0;
    SDL_GetRendererOutputSize(renderer.get(), &width, &height);
    wish.width = std::max(width - static_cast<int>(panel_width), 16), wish.height = std::max(height, 16);
    if (worker.wish(wish)) SDL_SetWindowTitle(window.get(), "bccsplat viewer");

    SDL_SetRenderDrawColor(renderer.get(), 0, 0, 0, 255);
    SDL_RenderClear(renderer.get());
    const SDL_Rect place{static_cast<int>(panel_width), 0, wish.width, wish.height};
    if (texture) SDL_RenderCopy(renderer.get(), texture.get(), nullptr, &place);
    ImGui::Render();
    draw_controls(renderer.get(), *ImGui::GetDrawData());
    if (!open && screenshot) save_window(renderer.get(), screenshot);
    SDL_RenderPresent(renderer.get());
  }
  if (screenshot)
    std::printf("drafts %d fine %d cancelled %d rotate %.1f %.1f frame %.3f rounds %d iso %d value %.6g"
                " open %d%d%d to %.2f waited for %llu B by %s\n",
                worker.counts().drafts.load(), worker.counts().fine.load(), worker.counts().cancelled.load(),
                wish.rotate_x, wish.rotate_y, wish.frame, player.rounds(), wish.iso ? 1 : 0,
                wish.surfaces.front().value, wish.open[0] ? 1 : 0, wish.open[1] ? 1 : 0, wish.open[2] ? 1 : 0,
                wish.open_to[0], static_cast<unsigned long long>(worker.counts().waited_for.load()),
                worker.counts().by_gpu.load() ? "gpu" : "cpu");
  ImGui_ImplSDL2_Shutdown();
  ImGui::DestroyContext();
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  int code = 1;
  try {
    const std::optional<Arguments> arguments = read_arguments(argc, argv);
    if (!arguments) {
      std::fputs(help, stderr);
      return 2;
    }
    if (SDL_Init(SDL_INIT_VIDEO) != 0) throw std::runtime_error(SDL_GetError());
    code = run(*arguments);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
  }
  SDL_Quit();
  return code;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* write_in_situ OUT.bcc4: a simulation that samples the lattice itself, with no Cartesian grid in between.
 * Two soft blobs circle each other; the lattice is asked layer by layer where its sites stand. C99 and the
 * public header only. */
#include <bccsplat.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static double blob(double x, double y, double z) { return exp(-(x * x + y * y + z * z) / (2 * 5.0 * 5.0)); }

/* The field at (x, y, z) voxels and t frames. */
static double field(double x, double y, double z, double t) {
  const double angle = 0.2 * t, u = 12 * cos(angle), v = 12 * sin(angle);
  return blob(x - 24 - u, y - 24 - v, z - 24) + 0.6 * blob(x - 24 + u, y - 24 + v, z - 24);
}

/* Tells what failed; 1 when it did. */
static int failed(const char* what, bccsplat_status status) {
  if (status == BCCSPLAT_OK) return 0;
  fprintf(stderr, "%s: %s (%s)\n", what, bccsplat_last_error(), bccsplat_status_name(status));
  return 1;
}

/* Fills and adds one layer; 1 when something failed. */
static int add_layer(bccsplat_writer* writer, int64_t layer, int64_t* layer_count) {
  bccsplat_layer_geometry g = {.struct_size = sizeof g};
  float *samples, *next;
  int64_t i, j, k;
  int bad;
  if (failed("geometry", bccsplat_writer_get_layer_geometry(writer, layer, &g))) return 1;
  *layer_count = g.layer_count;
  samples = next = malloc((size_t)(g.dims[0] * g.dims[1] * g.dims[2]) * sizeof *samples);
  if (!samples) return 1;
  for (k = 0; k < g.dims[2]; ++k)
    for (j = 0; j < g.dims[1]; ++j)
      for (i = 0; i < g.dims[0]; ++i) /* x is fastest */
        *next++ = (float)field(g.origin[0] + g.step[0] * (double)i, g.origin[1] + g.step[1] * (double)j,
                               g.origin[2] + g.step[2] * (double)k, g.frame);
  bad = failed("layer", bccsplat_writer_add_layer(writer, 0, layer, samples, (uint64_t)(next - samples)));
  free(samples);
  return bad;
}

int main(int argc, char** argv) {
  bccsplat_device* device = NULL;
  bccsplat_writer* writer = NULL;
  bccsplat_channel_options channel = {
      .struct_size = sizeof channel, .name = "density", .air_threshold = 1e-3};
  bccsplat_writer_options options = {.struct_size = sizeof options, .dims = {49, 49, 49, 17}, .overwrite = 1};
  bccsplat_writer_report report = {.struct_size = sizeof report};
  int64_t layer, layer_count = 1;
  int bad = 1;

  if (argc != 2) {
    fprintf(stderr, "usage: write_in_situ OUT.bcc4\n");
    return 2;
  }
  options.channel_count = 1;
  options.channels = &channel;
  if (failed("device", bccsplat_device_create(NULL, &device))) goto done;
  if (failed(argv[1], bccsplat_writer_create(device, argv[1], &options, &writer))) goto done;
  for (layer = 0; layer < layer_count; ++layer)
    if (add_layer(writer, layer, &layer_count)) goto done;
  if (failed(argv[1], bccsplat_writer_finish(writer, &report))) goto done;
  printf("%llu of %llu lattice sites kept, where a grid has %llu samples\n",
         (unsigned long long)report.sites_kept, (unsigned long long)report.sites_total,
         (unsigned long long)report.cc_samples);
  bad = 0;

done: /* without finish the release leaves no file */
  bccsplat_writer_release(writer);
  bccsplat_device_release(device);
  return bad;
}

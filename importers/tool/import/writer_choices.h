// SPDX-License-Identifier: Apache-2.0
// Names of the writer's settings on the command line and in plans.
#pragma once

#include <cstdint>

#include "tool/handles.h"
#include "tool/options.h"

namespace bcc4 {

inline const Choices<int32_t> kNonfiniteChoices{{"error", BCCSPLAT_NONFINITE_ERROR},
                                                {"hole", BCCSPLAT_NONFINITE_HOLE},
                                                {"clamp", BCCSPLAT_NONFINITE_CLAMP}};
inline const Choices<int32_t> kLatticeChoices{
    {"d4star", BCCSPLAT_LATTICE_D4STAR}, {"bcc", BCCSPLAT_LATTICE_BCC}, {"cc", BCCSPLAT_LATTICE_CC}};
inline const Choices<int32_t> kMeasureChoices{
    {"none", BCCSPLAT_MEASURE_DEFAULT}, {"some", BCCSPLAT_MEASURE_SOME}, {"all", BCCSPLAT_MEASURE_ALL}};
inline const Choices<int32_t> kTypeChoices{{"u8", BCCSPLAT_TYPE_U8},
                                           {"u16", BCCSPLAT_TYPE_U16},
                                           {"f16", BCCSPLAT_TYPE_F16},
                                           {"f32", BCCSPLAT_TYPE_F32}};
inline const Choices<int32_t> kFacesChoices{
    {"predict", BCCSPLAT_FACES_PREDICT},
    {"mirror", BCCSPLAT_FACES_MIRROR},
    {"x", BCCSPLAT_FACES_PREDICT_X},
    {"y", BCCSPLAT_FACES_PREDICT_Y},
    {"z", BCCSPLAT_FACES_PREDICT_Z},
    {"xy", BCCSPLAT_FACES_PREDICT_X + BCCSPLAT_FACES_PREDICT_Y},
    {"xz", BCCSPLAT_FACES_PREDICT_X + BCCSPLAT_FACES_PREDICT_Z},
    {"yz", BCCSPLAT_FACES_PREDICT_Y + BCCSPLAT_FACES_PREDICT_Z},
    {"xyz", BCCSPLAT_FACES_PREDICT_X + BCCSPLAT_FACES_PREDICT_Y + BCCSPLAT_FACES_PREDICT_Z}};
// Axes that are periodic.
inline const Choices<int32_t> kPeriodicChoices{
    {"x", BCCSPLAT_PERIODIC_X},
    {"y", BCCSPLAT_PERIODIC_Y},
    {"z", BCCSPLAT_PERIODIC_Z},
    {"xy", BCCSPLAT_PERIODIC_X + BCCSPLAT_PERIODIC_Y},
    {"xz", BCCSPLAT_PERIODIC_X + BCCSPLAT_PERIODIC_Z},
    {"yz", BCCSPLAT_PERIODIC_Y + BCCSPLAT_PERIODIC_Z},
    {"xyz", BCCSPLAT_PERIODIC_X + BCCSPLAT_PERIODIC_Y + BCCSPLAT_PERIODIC_Z}};
inline const Choices<int32_t> kEndsChoices{{"predict", BCCSPLAT_ENDS_PREDICT},
                                           {"mirror", BCCSPLAT_ENDS_MIRROR},
                                           {"periodic", BCCSPLAT_ENDS_PERIODIC}};
inline const Choices<int32_t> kStoreChoices{{"samples", BCCSPLAT_STORE_SAMPLES},
                                            {"wavelets", BCCSPLAT_STORE_WAVELETS}};

} // namespace bcc4

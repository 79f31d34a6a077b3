// SPDX-License-Identifier: Apache-2.0
#include "rack_image_scene.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/statistics/draw.hpp"
#include "rack_texture_bake.hpp"

namespace pipescout::simulation::internal {
namespace {

constexpr std::uint64_t kTexturePurpose = 1;
constexpr std::uint64_t kFinishPurpose = 2;
constexpr std::uint64_t kClutterPurpose = 3;
constexpr std::uint64_t kPipePurpose = 100;  // and on, one per pipe

PipeFinish draw_finish(std::mt19937_64& engine) {
  static constexpr PipeFinish kKinds[] = {
      {.albedo = 0.58, .rust = 0.05, .contrast = 0.8, .gloss = 0.30},  // aluminium jacket
      {.albedo = 0.17, .rust = 0.60, .contrast = 1.0, .gloss = 0.03},  // bare steel
      {.albedo = 0.36, .rust = 0.25, .contrast = 1.0, .gloss = 0.12},  // grey paint
      {.albedo = 0.10, .rust = 0.15, .contrast = 1.0, .gloss = 0.08},  // bitumen
      {.albedo = 0.48, .rust = 0.35, .contrast = 1.0, .gloss = 0.15},  // old white paint
  };
  PipeFinish finish =
      kKinds[static_cast<std::size_t>(statistics::uniform(engine, 0, std::size(kKinds)))];
  finish.albedo *= statistics::uniform(engine, 0.85, 1.15);
  finish.rust *= statistics::uniform(engine, 0.7, 1.4);
  return finish;
}

/// The stretches of rack y, as places along a pipe.
std::vector<PlainStretch> along_pipe(const rack_vision::Pipe& pipe,
                                     const std::vector<PlainStretch>& plain) {
  std::vector<PlainStretch> stretches;
  const double slope = pipe.direction.y();
  for (const PlainStretch& stretch : plain) {
    if (std::abs(slope) > 1e-6) {
      const double a = (stretch.from - pipe.start.y()) / slope;
      const double b = (stretch.to - pipe.start.y()) / slope;
      stretches.push_back({std::min(a, b), std::max(a, b)});
    } else if (pipe.start.y() >= stretch.from && pipe.start.y() <= stretch.to) {
      stretches.push_back({0, pipe.length()});
    }
  }
  return stretches;
}

void add_bodies(const SceneBodies& added, Bodies& bodies) {
  for (const SceneCylinder& cylinder : added.cylinders) {
    bodies.cones.push_back({.start = cylinder.start,
                            .axis = cylinder.direction,
                            .length = cylinder.length,
                            .radius = cylinder.radius,
                            .albedo = static_cast<float>(cylinder.albedo)});
  }
  for (const SceneBox& box : added.boxes) {
    bodies.boxes.push_back({.low = box.lowest_corner,
                            .high = box.highest_corner,
                            .albedo = static_cast<float>(box.albedo)});
  }
}

}  // namespace

BuiltScene build_scene(const RackScene& scene) {
  BuiltScene built;
  built.bodies.ground_height = scene.ground_height;
  std::mt19937_64 texture_engine = statistics::make_engine(scene.seed, kTexturePurpose);
  std::mt19937_64 finish_engine = statistics::make_engine(scene.seed, kFinishPurpose);
  const Fractal fractal(texture_engine);
  built.wardrobe.ground = bake_ground(scene.ground_albedo, fractal, texture_engine);
  built.wardrobe.grime = bake_grime(fractal);
  for (std::size_t i = 0; i < scene.model.pipes.size(); ++i) {
    const rack_vision::Pipe& pipe = scene.model.pipes[i];
    const PipeFinish finish =
        scene.finishes.empty() ? draw_finish(finish_engine) : scene.finishes[i];
    std::mt19937_64 engine = statistics::make_engine(scene.seed, kPipePurpose + i);
    int texture = -1;
    double step = 1;
    if (finish.contrast > 0) {
      texture = static_cast<int>(built.wardrobe.pipes.size());
      built.wardrobe.pipes.push_back(bake_pipe(finish, pipe.largest_radius(), pipe.length(),
                                               along_pipe(pipe, scene.plain), fractal, engine));
      step = pipe.length() / built.wardrobe.pipes.back().height();
    }
    std::vector<rack_vision::PipeSection> sections;
    rack_vision::append_sections(pipe, 0, sections);
    for (const rack_vision::PipeSection& section : sections) {
      built.bodies.cones.push_back(
          {.start = section.start,
           .axis = section.direction,
           .length = section.length,
           .radius = section.radius_start,
           .slope = (section.radius_end - section.radius_start) / section.length,
           .texture = texture,
           .texture_along = (section.start - pipe.start).dot(section.direction),
           .texture_step = step,
           .albedo = static_cast<float>(finish.albedo),
           .gloss = static_cast<float>(finish.gloss)});
    }
    built.axes_height += (pipe.start.z() + 0.5 * pipe.length() * pipe.direction.z()) /
                         static_cast<double>(scene.model.pipes.size());
  }
  std::mt19937_64 clutter_engine = statistics::make_engine(scene.seed, kClutterPurpose);
  for (const rack_vision::Support& support : scene.model.supports) {
    built.bodies.boxes.push_back(
        {.low = support.lowest_corner,
         .high = support.highest_corner,
         .albedo = static_cast<float>(statistics::uniform(clutter_engine, 0.2, 0.4))});
  }
  add_bodies(scene.bodies, built.bodies);
  built.first_person = built.bodies.cones.size();
  built.people = scene.people;
  constexpr float kClothes = 0.25F;
  built.bodies.cones.insert(built.bodies.cones.end(), scene.people,
                            {.axis = Eigen::Vector3d::UnitZ(),
                             .length = kPersonHeight,
                             .radius = kPersonRadius,
                             .albedo = kClothes});
  add_clutter(scene.model, scene.clutter_share, clutter_engine, built.bodies);
  return built;
}

}  // namespace pipescout::simulation::internal

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/simulation/rack_image.hpp"

/// A second renderer of racks, to see whether a figure is one of the tracker or of the renderer
/// that it was made with. It shares no code with `simulation::RackImageRenderer` nor with the
/// tracker's contours: pipes and beams are meshes of triangles, drawn row by row with a depth
/// buffer; paint, ground, light and lens are others too.
namespace pipescout::rack_study {

struct MeshScene {
  rack_vision::RackModel model;      ///< true positions of the pipes
  simulation::SceneBodies bodies{};  ///< which throw the light back as the seed says, not by albedo
  std::size_t people = 0;            ///< as of simulation::RackScene
  double contrast = 1;               ///< of the texture of pipes; 0: plain paint; [0, 2]
  double noise = 1;                  ///< grey levels, one sigma, [0, 100]
  std::uint64_t seed = 1;            ///< of paints, textures, light and noise

  /// Throws std::invalid_argument naming the field, the value and the range; for the model as
  /// RackModel::validate.
  void validate() const;
};

class MeshRenderer {
 public:
  /// Throws as MeshScene::validate, and for a camera with distortion or skew.
  MeshRenderer(const MeshScene& scene, const geometry::Camera& camera);

  /// `grey`: height * width, row-major; `frame` chooses the noise; `people`: where they stand, rack
  /// frame, m. The same arguments give the same bits. Throws std::invalid_argument when `grey` has
  /// another size, or the number of people is not that of the scene.
  void render(const geometry::SE3& T_camera_rack, std::uint64_t frame, std::span<std::uint8_t> grey,
              std::span<const Eigen::Vector3d> people = {});

 private:
  struct Triangle {
    std::array<Eigen::Vector3d, 3> corners;  ///< rack frame, m
    Eigen::Vector3d normal;                  ///< outward
    std::int16_t body = 0;
  };
  struct Intrinsics {
    Eigen::Matrix3d matrix, inverse;
  };
  /// A pipe or a box, as the light sees it.
  struct Body {
    bool is_pipe = false;
    Eigen::Vector3d start = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    double length = 0;
    double radius = 0;  ///< the largest
    Eigen::Vector3d lowest_corner = Eigen::Vector3d::Zero();
    Eigen::Vector3d highest_corner = Eigen::Vector3d::Zero();
    float paint = 0;   ///< reflectance
    double phase = 0;  ///< of its texture
    /// Where its triangles are now, against where they were added: people move.
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  };

  void add_pipe(const rack_vision::Pipe& pipe, float paint, double phase);
  void add_bodies(std::mt19937_64& engine);
  void add_box(const rack_vision::Support& support, float paint, double phase);
  void draw(const Triangle& triangle, const Intrinsics& intrinsics,
            const geometry::SE3& T_camera_rack);
  void draw_clipped(const std::array<Eigen::Vector3d, 3>& corners, const Intrinsics& intrinsics,
                    std::int16_t body);
  [[nodiscard]] float radiance(const Eigen::Vector3d& place, const Eigen::Vector3d& eye,
                               std::int16_t body) const;
  void place_people(std::span<const Eigen::Vector3d> people);
  /// Sorts the pipes into the cells in which the sun sees them. People are in none.
  void sort_by_shadow();
  /// A place as the sun sees it: in a plane across its light, m.
  [[nodiscard]] Eigen::Vector2d seen_by_sun(const Eigen::Vector3d& place) const;
  [[nodiscard]] std::size_t shadow_cell(const Eigen::Vector2d& seen) const;
  [[nodiscard]] bool in_shadow(const Eigen::Vector3d& place, std::int16_t body) const;

  MeshScene scene_;
  geometry::Camera camera_;
  int width_ = 0;  ///< of the buffers: finer than the image
  int height_ = 0;
  Eigen::Vector3d to_sun_;
  std::vector<Triangle> triangles_;
  std::vector<Body> bodies_;  ///< the people last
  Eigen::Matrix<double, 2, 3> sun_axes_ = Eigen::Matrix<double, 2, 3>::Zero();
  Eigen::Vector2d shadow_corner_ = Eigen::Vector2d::Zero();
  Eigen::Vector2i shadow_cells_ = Eigen::Vector2i::Ones();
  std::vector<std::vector<std::int16_t>> casters_;  ///< of each cell
  std::vector<float> nearness_;                     ///< 1 / depth
  std::vector<std::int16_t> body_;
  std::vector<float> radiance_;
  std::vector<float> blurred_;
};

}  // namespace pipescout::rack_study

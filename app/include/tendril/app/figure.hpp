#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tendril/app/files.hpp"
#include "tendril/problem.hpp"

namespace tendril::app {

/// What a figure of a plan shows, in SI units. A plan does not own its obstacles, so their outlines are kept here.
struct FigureScene {
  struct Shape {
    std::string name;
    std::vector<Vec2> outline;  ///< closed; may be empty if nothing of the shape is in view
  };
  std::vector<Shape> obstacles;
  bool obstacles_ignored = false;  ///< the plan knows nothing of them
  std::vector<Vec2> measured;      ///< points that an estimate started from
  std::optional<Vec2> target;
  std::optional<double> target_angle;
  Vec2 base{};
  double base_angle = 0.0;
  RodSpec rod, other_rod;  ///< whose bodies are drawn; of a grasp the upper and the lower finger
  std::optional<Vec2> gravity;
  std::optional<GripperSpec> gripper;  ///< the other finger of a grasp is drawn too
  std::string title;
  std::string doubt;  ///< why the shape is no plan, as "unstable"; empty: it is one
};

/// What a figure of a plan for `scene` shows. `obstacles` are dimensionless and in the order of the scene; null entries
/// are skipped.
FigureScene figure_scene(const Scene& scene, const std::vector<std::unique_ptr<Obstacle>>& obstacles);

/// A page holds the drawing and what shows it (figure/page.hpp); the others are made by gnuplot.
enum class Picture { svg, png, pdf, page };

/// Draws the plan with gnuplot: `stem`.svg, .png or .pdf, and beside them the script `stem`.gnuplot and its data
/// `stem`.dat. Throws InputError if gnuplot is missing or fails.
void draw_figure(const FigureScene& scene, const Plan& plan, StagedFiles& files, const std::string& stem,
                 const std::vector<Picture>& pictures);

/// `text` as a string of a gnuplot script: in single quotes, where nothing is expanded. Control characters become
/// blanks and quotes typographic ones: gnuplot 5.4 ends a string too early where doubled quotes stand at its beginning
/// or in a row.
std::string gnuplot_string(const std::string& text);

/// The kind of picture that a file name asks for. Throws InputError if it ends in none of .svg, .png, .pdf and .html or
/// cannot be written down in a script.
Picture picture_of(const std::filesystem::path& file);

/// Puts the object and the other finger of a grasp into a figure of its plan.
void add_gripper(FigureScene& figure, const Scene& scene, const Plan& plan);
/// The round object of a grasp.
FigureScene::Shape object_shape(Vec2 center, double radius);

}  // namespace tendril::app

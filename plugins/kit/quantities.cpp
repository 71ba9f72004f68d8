#include "quantities.hpp"

namespace tendril::kit {

namespace {

void add_backbone_point(std::vector<Input>& all, const std::string& owner, bool position, bool angle, bool curvature,
                        const std::string& reads) {
  const bool is_tip = owner == "tip";
  all.push_back({owner + ".x", is_tip ? "tip_position" : reads, position, -1.0, 1.0});
  all.push_back({owner + ".y", is_tip ? "tip_position" : reads, position, -1.0, 1.0});
  all.push_back({owner + ".angle", is_tip ? "tip_angle" : reads, angle, -2.0, 2.0});
  all.push_back({owner + ".curvature", is_tip ? "" : reads, curvature, -4.0, 4.0});
  all.push_back({owner + ".strain", is_tip ? "" : reads, curvature, -0.3, 0.3});
}

}  // namespace

std::vector<Input> inputs(const Reads& reads, int contacts, int moments) {
  std::vector<Input> all;
  add_backbone_point(all, "tip", reads.tip_position, reads.tip_angle, false, "");
  for (std::size_t i = 0; i < reads.samples.size(); ++i) {
    add_backbone_point(all, "samples[" + std::to_string(i) + "]", true, true, true, "samples");
  }
  for (int c = 0; c < contacts; ++c) {
    const std::string owner = "contacts[" + std::to_string(c) + "].";
    all.push_back({owner + "x", "contact_point", reads.contact_point, -1.0, 1.0});
    all.push_back({owner + "y", "contact_point", reads.contact_point, -1.0, 1.0});
    all.push_back({owner + "gap", "contact_gap", reads.contact_gap, 0.01, 0.5});
    all.push_back({owner + "normal_x", "contact_normal", reads.contact_normal, -1.0, 1.0});
    all.push_back({owner + "normal_y", "contact_normal", reads.contact_normal, -1.0, 1.0});
    all.push_back({owner + "force", "contact_force", reads.contact_force, 0.01, 3.0});
    all.push_back({owner + "arc_length", "contact_arc_length", reads.contact_arc_length, 0.1, 0.9});
    all.push_back({owner + "reference_x", "contact_point", reads.contact_point, -1.0, 1.0});
    all.push_back({owner + "reference_y", "contact_point", reads.contact_point, -1.0, 1.0});
  }
  const auto add_actuators = [&](const std::string& name, bool asked, double low, double high) {
    for (int a = 0; a < moments; ++a) all.push_back({name + "[" + std::to_string(a) + "]", name, asked, low, high});
  };
  add_actuators("moments", reads.moments, -3.0, 3.0);
  add_actuators("tensions", reads.tensions, 0.0, 40.0);
  add_actuators("shortenings", reads.shortenings, -0.1, 0.1);
  for (int a = 0; a < moments; ++a) {
    const std::string owner = "tip_deviations[" + std::to_string(a) + "].";
    for (const char* part : {"x", "y"})
      all.push_back({owner + part, "tip_deviations", reads.tip_deviations, -0.1, 0.1});
  }
  all.push_back({"bending_energy", "bending_energy", reads.bending_energy, 0.01, 5.0});
  all.push_back({"insertion", "insertion", reads.insertion, 0.5, 1.0});
  all.push_back({"palm_distance", "palm_distance", reads.palm_distance, 0.1, 1.0});
  return all;
}

}  // namespace tendril::kit

#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tendril/app/result.hpp"

namespace tendril::app {

using Json = nlohmann::ordered_json;

/// null for a number that is not finite.
Json number(double value);
Json numbers(const std::vector<double>& values);

/// `finger`: whose they are; empty: a plan of one rod.
/// What may be moved of a rod.
void add_place(Json& json, const RodPlace& place);
Json contacts_json(const std::vector<PlannedContact>& contacts, const std::string& finger = "");
Json backbone_json(const std::vector<BackbonePoint>& points);
Json snaps_json(const std::vector<Snap>& snaps);

/// A plan as it stands in every result, without what the command did around it.
Json plan_object(const Scene& scene, const Plan& plan);
/// What plan_json() and execution_json() write.
Json plan_result(const Scene& scene, const Plan& plan, const RunInfo& run);
Json execution_result(const Scene& scene, const Execution& execution, const RunInfo& run);
/// The parts of a target that are there.
Json target_json(const TargetSpec& target);
/// Where obstacles of the scene are that move: `obstacle`, `shift`, `turn`.
Json moved_obstacles_json(const Scene& scene, const std::vector<MovedObstacle>& moved);
/// Adds the diameters of a body at the points of a backbone, if there is a body.
void add_thickness(Json& json, const RodSpec& rod, const std::vector<BackbonePoint>& backbone);
/// Adds what a rod of the scene meets: its obstacles, their sizes in SI, how contact with them is planned, gravity.
void add_surroundings(Json& json, const Scene& scene);
Json left_out_json(const std::vector<LeftOut>& items);
Json components_json(const std::vector<UsedComponent>& components);
Json versions_json();

/// The document as text, ending in a line feed.
std::string written(const Json& json);

}  // namespace tendril::app

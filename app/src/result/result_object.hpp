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
Json contacts_json(const std::vector<PlannedContact>& contacts, const std::string& finger = "");
Json backbone_json(const std::vector<BackbonePoint>& points);

/// A plan as it stands in every result, without what the command did around it.
Json plan_object(const Scene& scene, const Plan& plan);
/// The scene's obstacles, their sizes in SI.
Json obstacles_json(const Scene& scene);
Json left_out_json(const std::vector<LeftOut>& items);
Json components_json(const std::vector<UsedComponent>& components);
Json versions_json();

/// The document as text, ending in a line feed.
std::string written(const Json& json);

}  // namespace tendril::app

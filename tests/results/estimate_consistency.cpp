// What an estimate says of its contacts, and of how well its shape fits the points.

#include <cmath>

#include "consistency.hpp"
#include "curve.hpp"

namespace tendril::results {

void check_estimate(const Json& result, const Scene& scene, Findings& found) {
  const double length = scene.rod.length();
  const ShownRod shown{"", scene.rod, scene.rod.base_position, scene.rod.base_angle};
  check_shape(result, shown, true, found);
  std::vector<double> breaks;
  for (const Json& contact : result.at("contacts")) breaks.push_back(contact.at("arc_length").get<double>());
  const Curve curve(result.at("backbone"), breaks);

  for (std::size_t k = 0; k < result.at("contacts").size(); ++k) {
    const Findings::Place place(found, "contact " + std::to_string(k + 1));
    const Json& contact = result.at("contacts").at(k);
    const double s = contact.at("arc_length").get<double>();
    const Vec2 on_rod = curve.at(s);
    // Rows of an estimate stand on no contact, so that the last step to it is an extrapolation of what is smooth.
    found.near("x of the point on the backbone", contact.at("point").at(0).get<double>(), on_rod.x, 1e-7 * length);
    found.near("y of the point on the backbone", contact.at("point").at(1).get<double>(), on_rod.y, 1e-7 * length);
    const Vec2 normal{contact.at("normal").at(0).get<double>(), contact.at("normal").at(1).get<double>()};
    const double angle = curve.angle(s);
    found.near("length of the normal", norm(normal), 1.0, 1e-12);
    found.near("normal . tangent", dot(normal, Vec2{std::cos(angle), std::sin(angle)}), 0.0, 1e-7);
    found.that(contact.at("force").get<double>() > 0.0, "the force pulls");
    const Json& covariance = result.at("covariance");
    const double force = std::sqrt(covariance.at(2 * k).at(2 * k).get<double>());
    const double place_error = std::sqrt(covariance.at(2 * k + 1).at(2 * k + 1).get<double>());
    found.near("error of the force", contact.at("force_error").get<double>(), force, 1e-12 * force);
    found.near("error of the place", contact.at("arc_length_error").get<double>(), place_error, 1e-12 * place_error);
    found.near("correlation", contact.at("correlation").get<double>(),
               covariance.at(2 * k).at(2 * k + 1).get<double>() / (force * place_error), 1e-9);
  }

  double squares = 0.0;
  for (const MeasuredPoint& seen : scene.measurement.points) {
    const Vec2 apart = seen.position - curve.at(seen.arc_length);
    squares += dot(apart, apart);
  }
  const auto values = 2.0 * static_cast<double>(scene.measurement.points.size());
  const double rms = std::sqrt(squares / values);
  const double noise = result.at("noise").get<double>();
  found.that(result.at("points") == scene.measurement.points.size(), "the number of points");
  found.near("noise", noise, scene.measurement.noise, 1e-15);
  // Residuals are 1e-3 of the length or less, and the curve is read to 1e-9 of it.
  found.near("rms of the residuals", result.at("residual_rms").get<double>(), rms, 1e-5 * rms);
  found.near("chi2", result.at("chi2").get<double>(), squares / (noise * noise), 1e-5 * squares / (noise * noise));
  const double unknowns = 2.0 * static_cast<double>(result.at("contacts").size());
  found.near("degrees of freedom", result.at("degrees_of_freedom").get<double>(), values - unknowns, 0.0);
}

}  // namespace tendril::results

#include "search/parameters.hpp"

#include <sstream>

#include "tendril/error.hpp"
#include "tendril/options.hpp"

namespace tendril {
namespace {

SearchParameters& in_force() {
  static SearchParameters parameters;
  return parameters;
}

template <class T>
void read(T& to, const std::string& name, const std::string& value) {
  std::istringstream in(value);
  T read{};
  if (!(in >> read) || !in.eof()) throw Error("search parameter '" + name + "': \"" + value + "\" is no number");
  to = read;
}

template <class T>
std::string told(T value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

}  // namespace

const SearchParameters& search_parameters() { return in_force(); }

std::vector<SearchParameter> list_search_parameters() {
  std::vector<SearchParameter> all;
#define TENDRIL_LIST(type, name, value, meaning) \
  all.push_back({#name, told(in_force().name), meaning, std::is_same_v<type, bool>});
  TENDRIL_SEARCH_PARAMETERS(TENDRIL_LIST)
#undef TENDRIL_LIST
  return all;
}

void set_search_parameter(const std::string& name, const std::string& value) {
#define TENDRIL_SET(type, known, initial, meaning) \
  if (name == #known) return read(in_force().known, name, value);
  TENDRIL_SEARCH_PARAMETERS(TENDRIL_SET)
#undef TENDRIL_SET
  std::vector<std::string> known;
  for (const SearchParameter& p : list_search_parameters()) known.push_back(p.name);
  throw Error("there is no search parameter '" + name + "'" + did_you_mean(name, known));
}

}  // namespace tendril

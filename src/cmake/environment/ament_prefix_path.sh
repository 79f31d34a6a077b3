# SPDX-License-Identifier: Apache-2.0
# Environment hook of colcon: puts the prefixes of the workspace into AMENT_PREFIX_PATH, where `ros2` looks for
# packages. One package of a workspace that names it in its colcon.pkg serves all of them: colcon has
# such a hook for ament packages only. Sourced by sh, bash and zsh, with COLCON_CURRENT_PREFIX set.

_pipescout_add_ament_prefix() {
  if [ -f "$1/share/ament_index/resource_index/packages/$2" ]; then
    case ":${AMENT_PREFIX_PATH-}:" in
      *":$1:"*) ;;
      *) AMENT_PREFIX_PATH="$1${AMENT_PREFIX_PATH:+:$AMENT_PREFIX_PATH}" ;;
    esac
  fi
}

# Merged, all packages share the prefix; isolated, each has one of its name beside this one.
_pipescout_layout="${COLCON_CURRENT_PREFIX%/*}/.colcon_install_layout"
if [ -f "$_pipescout_layout" ] && [ "$(cat "$_pipescout_layout")" = isolated ]; then
  for _pipescout_prefix in "${COLCON_CURRENT_PREFIX%/*}"/*; do
    _pipescout_add_ament_prefix "$_pipescout_prefix" "${_pipescout_prefix##*/}"
  done
  unset _pipescout_prefix
else
  for _pipescout_marker in "$COLCON_CURRENT_PREFIX"/share/ament_index/resource_index/packages/*; do
    _pipescout_add_ament_prefix "$COLCON_CURRENT_PREFIX" "${_pipescout_marker##*/}"
  done
  unset _pipescout_marker
fi
export AMENT_PREFIX_PATH
unset _pipescout_layout
unset -f _pipescout_add_ament_prefix

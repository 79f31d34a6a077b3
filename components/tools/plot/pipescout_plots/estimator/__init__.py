# SPDX-License-Identifier: Apache-2.0
"""Pictures of what a state estimator said, and why. One module per picture; `subject` knows them all."""

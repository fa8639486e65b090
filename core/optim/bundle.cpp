#include "core/optim/bundle.h"

-- Until when a worker's answers were found to be right: a master that begins looks into the others.

PRAGMA user_version = 3;

-- When the last of its answers had been evaluated again and was right; null: not yet. Of a worker that is connected it is null.
ALTER TABLE worker ADD COLUMN audited_at TEXT;

-- Those that left before this was noted had been looked into when they left.
UPDATE worker SET audited_at = left_at;

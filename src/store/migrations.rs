//! Brings a database to the present schema.

use rusqlite::{Connection, TransactionBehavior};

use super::OpenError;

/// Each one leads from the schema numbered by its position to the next.
const MIGRATIONS: &[&str] = &[include_str!("migrations/0001_jobs_and_robots.sql")];

/// Applies what is missing, each step in one transaction with its number.
pub(super) fn migrate(connection: &mut Connection) -> Result<(), OpenError> {
    let found: u32 = connection.pragma_query_value(None, "user_version", |row| row.get(0))?;
    let found = usize::try_from(found).unwrap_or(usize::MAX);
    if found > MIGRATIONS.len() {
        return Err(OpenError::NewerSchema { found, known: MIGRATIONS.len() });
    }
    for (version, sql) in (1_u32..).zip(MIGRATIONS).skip(found) {
        let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
        transaction.execute_batch(sql)?;
        transaction.pragma_update(None, "user_version", version)?;
        transaction.commit()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn migrating_twice_changes_nothing_and_a_newer_schema_is_left_alone() {
        let mut connection = Connection::open_in_memory().unwrap();
        migrate(&mut connection).unwrap();
        connection.execute("INSERT INTO robots VALUES ('a', '{}')", []).unwrap();
        migrate(&mut connection).unwrap();
        let count = |c: &Connection| c.query_row("SELECT count(*) FROM robots", [], |r| r.get(0));
        assert_eq!(count(&connection), Ok(1));
        connection.pragma_update(None, "user_version", 99).unwrap();
        let error = migrate(&mut connection).unwrap_err();
        assert!(matches!(error, OpenError::NewerSchema { found: 99, known: 1 }), "{error}");
    }
}
